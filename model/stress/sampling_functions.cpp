// Samplers. They are double alone; the reference inverts the cumulative in 100 digits by itself.
#include "model/phase.h"
#include "model/profiles/better_dipole.h"
#include "model/profiles/normalised_diffusion.h"
#include "model/profiles/poles.h"
#include "model/stress/function.h"

#include <algorithm>

namespace opaline {
namespace {

StressFunction sampler(std::string name, Domain domain, double limit, std::function<double(const double*)> value,
                       std::function<Wide(const Wide*)> reference) {
  StressFunction row;
  row.name = std::move(name);
  row.domain = std::move(domain);
  row.limit = limit;
  row.value = std::move(value);
  row.reference = std::move(reference);
  return row;
}

/// w = d/z - 1 with c w + log(1 + w) = -log(1 - xi) by Newton's method in log(1 + w), from the right of the root.
Wide pole_excess(const Wide& c, const Wide& xi) {
  const Wide target = -log1p(Wide(-xi));
  Wide v = target;
  if (c > 0) v = std::min(v, Wide(log1p(Wide(target / c))));
  for (int i = 0; i < 100; ++i) {
    const Wide w = expm1(v), step = (c * w + v - target) / (c * (w + 1) + 1);
    v -= step;
    if (abs(step) <= Wide("1e-60") * v) break;
  }
  return expm1(v);
}

Wide pole_reference(const Wide& z, const Wide& sigma, const Wide& xi) {
  if (xi <= 0) return 0;
  const Wide w = pole_excess(Wide(sigma * z), xi);
  return z * sqrt(Wide(w * (w + 2)));
}

Wide pole_pair_reference(const Wide* x) {
  const Wide &near = x[0], &far = x[1], &sigma = x[2], &xi = x[3];
  const Wide decay = exp(Wide(-sigma * (far - near))), share = 1 / (1 + decay);
  if (xi < share) return pole_reference(near, sigma, Wide(xi / share));
  return pole_reference(far, sigma, Wide((xi - share) / (decay * share)));
}

Axis decay_axis() { return {"sigma z", {0, 1e-300, 1e-12, 1e-3, 1, 1e3, 1e12, 1e300}, 1e-20, 1e20}; }

/// Below that d/z - 1 is no normal number: see sample_pole.
bool normal_excess(double sigma_z, double xi) { return xi == 0 || xi / (1 + sigma_z) > 1e-290; }

Domain one_pole() {
  return {.axes = {{"z", {1e-3, 1, 1e3}, 1e-3, 1e3}, decay_axis(), share_axis()},
          .to_inputs = [](Input& x) { x[1] /= x[0]; },
          .valid = [](const Input& x) { return normal_excess(x[0] * x[1], x[2]); },
          .inputs = {"z", "sigma", "xi"}};
}

/// z_far/z_near as eta from 0.3 to 3.5 makes it.
Domain two_poles() {
  return {.axes = {{"z_near", {1}, 1e-3, 1e3}, {"z_far/z_near", {2.4, 40}, 2.3, 60}, decay_axis(), share_axis()},
          .to_inputs =
              [](Input& x) {
                x[2] /= x[0];
                x[1] *= x[0];
              },
          .valid = [](const Input& x) { return normal_excess(x[1] * x[2], x[3]); },
          .inputs = {"z_near", "z_far", "sigma", "xi"}};
}

Domain medium_and_share() { return medium_domain(0.3, 3.5, share_axis(), "xi", &to_medium); }

/// cumulative(r) = xi total by Newton's method in log r on the logarithm of the smaller share, from the double's
/// answer.
Wide better_dipole_reference(const Wide* x) {
  const Medium<Wide> medium = medium_of(x);
  const BetterDipole<Wide> dipole(medium);
  const Wide total = dipole.total(), &xi = x[3];
  if (!(total > 0) || xi <= 0) return 0;
  const Medium<double> rounded{static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
  Wide r = BetterDipole<double>(rounded).sample(static_cast<double>(xi));
  for (int i = 0; i < 60; ++i) {
    const Wide share = dipole.cumulative(r) / total, slope = 2 * pi * r * r * dipole.evaluate(r) / total;
    const bool low = xi < 0.5;
    const Wide excess = low ? Wide(log(Wide(share / xi))) : Wide(-log(Wide((1 - share) / (1 - xi))));
    const Wide step = excess * (low ? share : Wide(1 - share)) / slope;
    r *= exp(Wide(-step));
    if (abs(step) <= Wide("1e-60")) break;
  }
  return r;
}

/// The two branches of NormalisedDiffusion::sample, the cubic y^3 + 3 y = 4 (1 - xi) by Newton's method.
Wide normalised_diffusion_reference(const Wide* x) {
  using Diffusion = SearchlightNormalisedDiffusion<Wide>;
  const Diffusion shape(medium_of(x));
  const Wide &xi = x[3], core = Diffusion::core_flux();
  Wide h = 0;
  if (xi < core) {
    h = -shape.c * log1p(Wide(-xi / core));
  } else {
    Wide y = 1;
    for (int i = 0; i < 60; ++i) {
      const Wide step = (y * (y * y + 3) - 4 * (1 - xi)) / (3 * (y * y + 1));
      y -= step;
      if (abs(step) <= Wide("1e-60") * y) break;
    }
    h = std::max(Wide(0), Wide(-3 * shape.d * log(y) - shape.c));
  }
  return sqrt(Wide(h * (h + 2 * shape.c)));
}

Domain share_and_g() {
  return {.axes = {share_axis(), {"g", {-0.999, -1e-9, 0, 1e-9, 0.999}, 1e-3, 1, Spread::signed_share}}};
}

template <typename F>
StressFunction cosine_sampler(std::string name, F f) {
  StressFunction row =
      stress_function(std::move(name), share_and_g(), loose_limit, f);  // phase.h: digits go like 1 - |g|
  row.non_negative = false;
  row.monotone = Monotone{0, true};
  return row;
}

}  // namespace

void add_sampling_functions(std::vector<StressFunction>& rows) {
  rows.push_back(with_monotone(
      sampler(
          "sample_pole", one_pole(), tight_limit, [](const double* x) { return sample_pole(x[0], x[1], x[2]); },
          [](const Wide* x) { return pole_reference(x[0], x[1], x[2]); }),
      {2, true}));
  rows.push_back(sampler(
      "sample_pole_pair", two_poles(), tight_limit,
      [](const double* x) { return sample_pole_pair(x[0], x[1], x[2], x[3]); }, pole_pair_reference));
  rows.push_back(with_cost(
      with_monotone(
          sampler(
              "better_dipole.sample", medium_and_share(), loose_limit,
              [](const double* x) { return BetterDipole<double>(medium_of(x)).sample(x[3]); }, better_dipole_reference),
          {3, true}),
      4));
  rows.push_back(sampler(
      "normalised_diffusion.sample", scattering(medium_and_share()), loose_limit,
      [](const double* x) { return SearchlightNormalisedDiffusion<double>(medium_of(x)).sample(x[3]); },
      normalised_diffusion_reference));
  rows.push_back(
      cosine_sampler("sample_henyey_greenstein", [](const auto* x) { return sample_henyey_greenstein(x[0], x[1]); }));
  rows.push_back(
      cosine_sampler("sample_schlick_phase", [](const auto* x) { return sample_schlick_phase(x[0], x[1]); }));
}

}  // namespace opaline
