// Slabs and stacks: the multipole's sums, and the algebra of layers in the Hankel domain.
#include "model/profiles/layered.h"
#include "model/profiles/multipole.h"
#include "model/stress/function.h"

namespace opaline {
namespace {

/// A medium, a thickness and a radius or spatial frequency, the last three in units of the mean free path.
Domain slab_domain(std::optional<Axis> last, const std::string& input, void (*to_inputs)(Input&)) {
  Domain domain = medium_domain(0.3, 3.5, thickness_axis(), "d", to_inputs);
  if (!last) return domain;
  domain.axes.push_back(*last);
  domain.inputs.push_back(input);
  return domain;
}

Domain slab_and_radius() {
  return slab_domain(radius_axis(), "r", [](Input& x) {
    x[3] /= x[0];
    x[4] /= x[0];
    to_medium(x);
  });
}

Domain slab_and_frequency() {
  return slab_domain(Axis{"k l", {0, 1e-12, 1, 30}, 1e-12, 30}, "k", [](Input& x) {
    x[3] /= x[0];
    x[4] *= x[0];
    to_medium(x);
  });
}

Domain slab_alone() {
  return slab_domain(std::nullopt, "", [](Input& x) {
    x[3] /= x[0];
    to_medium(x);
  });
}

/// Lit through a boundary of the same index as below.
template <typename T>
Slab<T> slab_of(const T* x) {
  return {{x[0], x[1], x[2]}, x[3], x[2]};
}

/// gradient_scale: sigma_t' for the coefficients.
void with_medium_gradient(StressFunction& row) { row.gradient_scale = &medium_scale; }

void add_multipole(std::vector<StressFunction>& rows) {
  const auto reflected = [](const auto* x) { return Multipole(slab_of(x)).reflectance(x[4]); };
  const auto transmitted = [](const auto* x) { return Multipole(slab_of(x)).transmittance(x[4]); };
  rows.push_back(
      with_monotone(differentiated<3>("multipole.reflectance", slab_and_radius(), loose_limit, reflected), {4, false}));
  with_medium_gradient(rows.back());
  rows.push_back(with_monotone(
      differentiated<3>("multipole.transmittance", slab_and_radius(), loose_limit, transmitted), {4, false}));
  with_medium_gradient(rows.back());
  for (StressFunction* row : {&rows[rows.size() - 2], &rows.back()}) row->cost = 16;
  rows.push_back(stress_function("multipole.total_reflectance", slab_alone(), loose_limit,
                                 [](const auto* x) { return Multipole(slab_of(x)).total_reflectance(); }));
  rows.push_back(stress_function("multipole.total_transmittance", slab_alone(), loose_limit,
                                 [](const auto* x) { return Multipole(slab_of(x)).total_transmittance(); }));
}

/// The slab above one of another index, thickness and albedo.
template <typename T>
Response<T> two_layers(const T* x) {
  const T l = 1.0 / (x[0] + x[1]);
  const std::vector<StackLayer<T>> layers = {{{x[0], x[1], x[2]}, x[3]},
                                             {{T(0.2 / l), T(3.0 / l), T(1.4)}, T(2.5 * l)}};
  return stack_response(stack_of(layers, T(1.0)), T(x[4] * x[4]));
}

template <typename F>
void add_stack(std::vector<StressFunction>& rows, const std::string& name, F part) {
  rows.push_back(with_cost(stress_function("layered." + name, slab_and_frequency(), loose_limit, part), 8));
}

}  // namespace

void add_slab_functions(std::vector<StressFunction>& rows) {
  add_multipole(rows);
  add_stack(rows, "reflected", [](const auto* x) { return two_layers(x).reflected; });
  add_stack(rows, "transmitted", [](const auto* x) { return two_layers(x).transmitted; });
  add_stack(rows, "absorbed", [](const auto* x) { return two_layers(x).absorbed; });
  add_stack(rows, "reflected_below", [](const auto* x) { return two_layers(x).reflected_below; });
}

}  // namespace opaline
