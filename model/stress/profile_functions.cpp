// Poles, Yukawa terms and the profiles made of them.
#include "model/profiles/better_dipole.h"
#include "model/profiles/directional_normal_beam.h"
#include "model/profiles/extended_source.h"
#include "model/profiles/normalised_diffusion.h"
#include "model/profiles/standard_dipole.h"
#include "model/profiles/transport_table.h"
#include "model/stress/function.h"

namespace opaline {
namespace {

constexpr double eta_low = 0.3, eta_high = 3.5;

Domain medium_and_radius(double low = eta_low, double high = eta_high) {
  return medium_domain(low, high, radius_axis(), "r", [](Input& x) {
    x[3] /= x[0];
    to_medium(x);
  });
}

/// Lengths in units of the pole's depth: (z, r/z, (sigma z)) to (r or r^2, z, sigma or sigma^2).
Domain pole_domain(std::vector<std::string> inputs, void (*to_inputs)(Input&)) {
  return {.axes = {{"z", {1e-6, 1, 1e6}, 1e-6, 1e6},
                   {"r/z", {0, 1e-12, 1, 1e6}, 1e-12, 1e6},
                   {"sigma z", {0, 1e-300, 1e-12, 1e-3, 1, 600, 1e12}, 1e-20, 1e3}},
          .to_inputs = to_inputs,
          .inputs = std::move(inputs)};
}

void add_pole_functions(std::vector<StressFunction>& rows) {
  rows.push_back(
      with_monotone(stress_function("screening", {.axes = {{"t", {0, 1e-300, 1e-12, 1, 3e5, 1e300}, 1e-30, 3e5}}},
                                    tight_limit, [](const auto* x) { return screening(x[0]); }),
                    {0, false}));
  const Domain squared = pole_domain({"q", "z", "sigma^2"}, [](Input& x) {
    x = {x[0] * x[1] * x[0] * x[1], x[0], x[2] / x[0] * (x[2] / x[0])};
  });
  rows.push_back(with_monotone(differentiated<3>("pole_evaluate_squared", squared, tight_limit,
                                                 [](const auto* x) { return pole_evaluate_squared(x[0], x[1], x[2]); }),
                               {1, false}));
  const Domain plain = pole_domain({"r", "z", "sigma"}, [](Input& x) { x = {x[0] * x[1], x[0], x[2] / x[0]}; });
  rows.push_back(with_monotone(stress_function("pole_cumulative", plain, tight_limit,
                                               [](const auto* x) { return pole_cumulative(x[0], x[1], x[2]); }),
                               {1, true}));
}

template <template <typename> class Profile>
StressFunction evaluate_row(const std::string& name, Domain domain, double limit) {
  const auto evaluate = []<typename T>(const T* x) { return Profile<T>(medium_of(x)).evaluate(x[3]); };
  StressFunction row = differentiated<3>(name + ".evaluate", std::move(domain), limit, evaluate);
  row.gradient_scale = &medium_scale;
  return with_monotone(std::move(row), {3, false});
}

template <template <typename> class Profile>
StressFunction cumulative_row(const std::string& name, Domain domain, double limit) {
  const auto cumulative = []<typename T>(const T* x) { return Profile<T>(medium_of(x)).cumulative(x[3]); };
  return with_monotone(stress_function(name + ".cumulative", std::move(domain), limit, cumulative), {3, true});
}

/// The total falls with the share that is absorbed.
template <template <typename> class Profile>
StressFunction total_row(const std::string& name, Domain domain, double limit) {
  const auto total = []<typename T>(const T* x) { return Profile<T>(medium_of(x)).total(); };
  return with_monotone(stress_function(name + ".total", std::move(domain), limit, total), {1, false});
}

template <template <typename> class Profile>
void add_dipole(std::vector<StressFunction>& rows, const std::string& name, double limit) {
  rows.push_back(evaluate_row<Profile>(name, medium_and_radius(), limit));
  rows.push_back(cumulative_row<Profile>(name, medium_and_radius(), limit));
  rows.push_back(total_row<Profile>(name, medium_domain(eta_low, eta_high), limit));
}

/// Normalised diffusion. Without absorption its derivative is infinite.
template <template <typename> class Profile>
void add_normalised(std::vector<StressFunction>& rows, const std::string& name) {
  rows.push_back(evaluate_row<Profile>(name, scattering(medium_and_radius()), loose_limit));
  rows.back().gradient_valid = [](const Input& x) { return x[0] > 0; };
  rows.push_back(cumulative_row<Profile>(name, scattering(medium_and_radius()), loose_limit));
  rows.push_back(total_row<Profile>(name, scattering(medium_domain(eta_low, eta_high)), loose_limit));
}

}  // namespace

void add_profile_functions(std::vector<StressFunction>& rows) {
  add_pole_functions(rows);
  add_dipole<StandardDipole>(rows, "standard_dipole", tight_limit);
  add_dipole<BetterDipole>(rows, "better_dipole", loose_limit);
  add_normalised<SearchlightNormalisedDiffusion>(rows, "normalised_diffusion");
  add_normalised<DiffuseNormalisedDiffusion>(rows, "normalised_diffusion_diffuse");
  rows.push_back(
      evaluate_row<DirectionalNormalBeam>("directional_dipole", scattering(medium_and_radius()), loose_limit));
  rows.push_back(with_cost(evaluate_row<ExtendedSource>("extended_source", medium_and_radius(), loose_limit), 8));
  rows.push_back(with_cost(cumulative_row<ExtendedSource>("extended_source", medium_and_radius(), loose_limit), 8));
  rows.push_back(
      with_cost(total_row<ExtendedSource>("extended_source", medium_domain(eta_low, eta_high), loose_limit), 8));
  rows.push_back(
      with_cost(evaluate_row<PhotonBeamDiffusion>("photon_beam_diffusion", medium_and_radius(), loose_limit), 8));
  const Domain table = medium_and_radius(TransportTableShape::eta_min, TransportTableShape::eta_max);
  rows.push_back(with_cost(evaluate_row<TransportTable>("transport_table", scattering(table), loose_limit), 64));
}

}  // namespace opaline
