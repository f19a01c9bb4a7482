#include "model/stress/function.h"

namespace opaline {

void to_medium(Input& x) {
  const double sigma_t_prime = x[0], absorbed = x[1];
  x[0] = sigma_t_prime * absorbed;
  x[1] = sigma_t_prime * (1 - absorbed);
}

Domain scattering(Domain medium) {
  medium.axes[1] = {"1 - alpha'", {0, 1e-15, 1e-12, 0.5, 0.9}, 1e-15, 0.9};
  return medium;
}

double medium_scale(const Input& x, std::size_t i) { return i < 2 ? x[0] + x[1] : x[i]; }

Axis share_axis() { return {"xi", {0, 1e-12, 0.5, 1 - 0x1p-53}, 1e-20, 1, Spread::share}; }

Axis radius_axis() { return {"r/l", {0, 1e-12, 1, 1e6}, 1e-12, 1e6}; }

Axis thickness_axis() { return {"d/l", {1e-6, 1, 2, 30, 1e6}, 1e-6, 1e6}; }

Axis eta_axis(double low, double high) {
  return {"eta", {0.5, 1 - 1e-9, 1, 1 + 1e-9, 3}, low, high, Spread::around_one};
}

Domain medium_domain(double eta_low, double eta_high) {
  Axis eta = eta_axis(eta_low, eta_high);
  std::erase_if(eta.corners, [&](double corner) { return corner < eta_low || corner > eta_high; });
  return {.axes = {{"sigma_t'", {1}, 1e-6, 1e6},
                   {"1 - alpha'", {0, 1e-15, 1e-12, 0.5, 1 - 1e-15, 1}, 1e-15, 1, Spread::share},
                   std::move(eta)},
          .to_inputs = &to_medium,
          .inputs = {"sigma_a", "sigma_s'", "eta"}};
}

Domain medium_domain(double eta_low, double eta_high, Axis last, const std::string& input, void (*to_inputs)(Input&)) {
  Domain domain = medium_domain(eta_low, eta_high);
  domain.axes.push_back(std::move(last));
  domain.inputs.push_back(input);
  domain.to_inputs = to_inputs;
  return domain;
}

std::vector<StressFunction> stress_functions() {
  std::vector<StressFunction> rows;
  add_fresnel_functions(rows);
  add_profile_functions(rows);
  add_slab_functions(rows);
  add_single_scattering_functions(rows);
  add_sampling_functions(rows);
  add_registry_functions(rows);
  add_float_functions(rows);
  return rows;
}

}  // namespace opaline
