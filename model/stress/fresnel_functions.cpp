// Fresnel reflection and its averages; phase functions.
#include "model/phase.h"
#include "model/stress/function.h"

namespace opaline {
namespace {

constexpr double eta_low = 0.3, eta_high = 3.5;  // where fresnel.h states its error

Axis cosine_axis() { return {"cos", {0, 1e-12, 0.5, 1}, 1e-12, 1, Spread::share}; }

Domain cosine_and_eta() {
  Domain domain{.axes = {cosine_axis(), eta_axis(eta_low, eta_high)}};
  // At eta = 1 there is no boundary, but beside it grazing light is reflected: no limit.
  domain.valid = [](const Input& x) { return x[0] > 0 || x[1] != 1; };
  return domain;
}

Domain eta_alone() { return {.axes = {eta_axis(eta_low, eta_high)}}; }

/// F and 1 - F are flat at both ends.
double cosine_scale(const Input& x, std::size_t i) { return i == 0 ? 1 : x[1]; }

template <typename F>
StressFunction of_cosine(std::string name, bool rising, F f) {
  StressFunction row = with_monotone(differentiated<2>(std::move(name), cosine_and_eta(), tight_limit, f), {0, rising});
  row.gradient_scale = &cosine_scale;
  return row;
}

/// A function of eta that rises or falls with the distance from 1, to either side.
template <typename F>
StressFunction average(std::string name, double limit, bool rising, F f) {
  StressFunction row = with_monotone(differentiated<1>(std::move(name), eta_alone(), limit, f), {0, rising, true});
  row.gradient_scale = [](const Input& x, std::size_t) { return x[0]; };  // some are flat at eta = 1
  return row;
}

Domain cosine_and_g() {
  return {.axes = {{"cos", {-1, -1e-12, 0, 1e-12, 1}, -1, 1, Spread::linear},
                   {"g", {-0.999, -1e-9, 0, 1e-9, 0.999}, 1e-3, 1, Spread::signed_share}}};
}

void add_phase_functions(std::vector<StressFunction>& rows) {
  rows.push_back(stress_function("henyey_greenstein", cosine_and_g(), tight_limit,
                                 [](const auto* x) { return henyey_greenstein(x[0], x[1]); }));
  rows.push_back(stress_function("schlick_phase", cosine_and_g(), tight_limit,
                                 [](const auto* x) { return schlick_phase(x[0], x[1]); }));
  const Domain k{.axes = {{"k", {-0.999, -0.03, -1e-9, 0, 1e-9, 0.03, 0.999}, 1e-3, 1, Spread::signed_share}}};
  rows.push_back(stress_function("schlick_k", k, tight_limit, [](const auto* x) { return schlick_k(x[0]); }));
  rows.back().non_negative = false;
  rows.push_back(
      stress_function("schlick_mean_cosine", k, loose_limit, [](const auto* x) { return schlick_mean_cosine(x[0]); }));
  rows.back().non_negative = false;
}

}  // namespace

void add_fresnel_functions(std::vector<StressFunction>& rows) {
  rows.push_back(
      of_cosine("fresnel_reflectance", false, [](const auto* x) { return fresnel_reflectance(x[0], x[1]); }));
  rows.push_back(
      of_cosine("fresnel_transmittance", true, [](const auto* x) { return fresnel_transmittance(x[0], x[1]); }));
  rows.push_back(average("diffuse_reflectance_external", tight_limit, true,
                         [](const auto* x) { return diffuse_reflectance_external(x[0]); }));
  rows.push_back(average("diffuse_reflectance_internal", tight_limit, true,
                         [](const auto* x) { return diffuse_reflectance_internal(x[0]); }));
  rows.push_back(average("diffuse_transmittance_external", tight_limit, false,
                         [](const auto* x) { return diffuse_transmittance_external(x[0]); }));
  rows.push_back(average("diffuse_transmittance_internal", tight_limit, false,
                         [](const auto* x) { return diffuse_transmittance_internal(x[0]); }));
  rows.push_back(
      average("dipole_boundary_a", tight_limit, true, [](const auto* x) { return dipole_boundary_a(x[0]); }));
  rows.push_back(
      average("second_moment_external", loose_limit, true, [](const auto* x) { return second_moment_external(x[0]); }));
  rows.push_back(
      average("second_moment_internal", loose_limit, true, [](const auto* x) { return second_moment_internal(x[0]); }));
  rows.push_back(
      average("exitance_weight_flux", loose_limit, false, [](const auto* x) { return exitance_weight_flux(x[0]); }));
  rows.push_back(
      average("modified_boundary_a", loose_limit, true, [](const auto* x) { return modified_boundary_a(x[0]); }));
  add_phase_functions(rows);
}

}  // namespace opaline
