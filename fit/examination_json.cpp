#include "fit/examination_json.h"

#include <cmath>

namespace opaline {
namespace {

using nlohmann::json;

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json triple(const Uncertainty& u, std::size_t first, double ParameterEstimate::*member) {
  json out = json::array();
  for (std::size_t c = 0; c < 3; ++c) out.push_back(number(u.parameters[first + c].*member));
  return out;
}

}  // namespace

json diagnosis_json(const Diagnosis& diagnosis) {
  json channels = json::array();
  for (const ChannelDiagnosis& c : diagnosis.channels) {
    json quantities;
    for (const Derived& q : c.quantities)
      quantities[q.name] = {{"value", number(q.value)}, {"relative_sd", number(q.relative_sd)}};
    channels.push_back({{"determines", c.sentence}, {"quantities", quantities}});
  }
  return channels;
}

json comparison_json(const ModelComparison& comparison) {
  json models = json::array();
  for (const ModelFit& m : comparison.models) {
    if (!m.same_as.empty()) {
      models.push_back({{"model", m.name}, {"same_as", m.same_as}});
      continue;
    }
    const Uncertainty& u = m.uncertainty;
    models.push_back({{"model", m.name},
                      {"relative_rmse", number(m.solution.relative_rmse)},
                      {"converged", m.solution.converged},
                      {"bic", number(m.bic)},
                      {"delta_bic", number(m.delta_bic)},
                      {"sigma_a_per_mm", triple(u, 0, &ParameterEstimate::value)},
                      {"sigma_a_sd", triple(u, 0, &ParameterEstimate::sd)},
                      {"sigma_s_prime_per_mm", triple(u, 3, &ParameterEstimate::value)},
                      {"sigma_s_prime_sd", triple(u, 3, &ParameterEstimate::sd)},
                      {"eta", number(u.parameters[eta_index].value)},
                      {"eta_sd", number(u.parameters[eta_index].sd)}});
  }
  return {{"fits", models},
          {"left_out", comparison.left_out},
          {"warnings", comparison.warnings},
          {"seconds", comparison.seconds}};
}

json bootstrap_json(const Bootstrap& b, const json& names) {
  json parameters = json::array();
  for (Eigen::Index i = 0; i < b.sd.size(); ++i) {
    const bool natural = i < parameter_count;
    const auto shown = [&](double v) { return number(natural ? natural_value(static_cast<int>(i), v) : v); };
    parameters.push_back({{"name", names[static_cast<std::size_t>(i)]},
                          {"sd_of_solver_parameter", number(b.sd[i])},
                          {"bias_of_solver_parameter", number(b.bias[i])},
                          {"ci95", {shown(b.low[i]), shown(b.high[i])}}});
  }
  return {{"repetitions", b.draws.rows()}, {"failed", b.failed}, {"parameters", parameters}, {"seconds", b.seconds}};
}

json correction_json(const Correction& c, const json& names) {
  json steps = json::array(), sensitivity = json::array();
  for (const CorrectionStep& step : c.steps) {
    json at;
    for (int i = 0; i < parameter_count; ++i)
      at[std::string(names[static_cast<std::size_t>(i)])] =
          number(natural_value(i, step.at[static_cast<std::size_t>(i)]));
    steps.push_back({{"at", at},
                     {"operator_relative_rms", number(step.defect)},
                     {"relative_residual", number(step.residual)},
                     {"next_step_sd", number(step.next_step_sd)},
                     {"better", step.better}});
  }
  for (Eigen::Index i = 0; i < c.sensitivity.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index j = 0; j < c.sensitivity.cols(); ++j) row.push_back(number(c.sensitivity(i, j)));
    sensitivity.push_back(row);
  }
  return {{"converged", c.converged}, {"renders", c.renders},       {"renders_saved", c.renders_saved},
          {"measured", c.measured},   {"sensitivity", sensitivity}, {"steps", steps},
          {"seconds", c.seconds}};
}

json surface_json(const SurfaceBias& s) {
  return {{"radius_mm", number(s.shape.radius_mm)},
          {"mean_incidence_deg", number(s.shape.incidence_deg)},
          {"radius_transport_mfp", {number(s.radius_mfp[0]), number(s.radius_mfp[1]), number(s.radius_mfp[2])}},
          {"measured_with", s.side_light ? "side light" : "a beam along the normal"},
          {"expected_error_sigma_a", s.sigma_a},
          {"expected_error_sigma_s_prime", s.sigma_s_prime}};
}

json advice_json(const std::vector<Advice>& advice) {
  json rows = json::array();
  for (const Advice& a : advice) {
    json sd = json::array();
    for (const double v : a.sd) sd.push_back(number(v));
    rows.push_back({{"add", a.what},
                    {"tightens_by", number(a.factor)},
                    {"sd_of_solver_parameters", sd},
                    {"light", a.light},
                    {"camera", a.camera}});
  }
  return rows;
}

}  // namespace opaline
