#include "fit/fit_output.h"

#include "fit/examination_json.h"
#include "fit/report/fit_report.h"

#include "render/input_error.h"
#include "render/scene/json_object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace opaline {
namespace {

using nlohmann::json;

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

/// One of the two RGB groups: entries first, first + 1, first + 2.
json group(const Uncertainty& u, int first) {
  json value, sd, ci, identifiable, reason, interval, free;
  for (int c = 0; c < 3; ++c) {
    const ParameterEstimate& e = u.parameters[static_cast<std::size_t>(first + c)];
    value.push_back(number(e.value));
    sd.push_back(number(e.sd));
    ci.push_back({number(e.low), number(e.high)});
    identifiable.push_back(e.identifiable);
    reason.push_back(e.reason);
    interval.push_back(e.interval);
    free.push_back(e.free);
  }
  const bool same = free[0] == free[1] && free[1] == free[2];
  return {{"value", value},      {"sd", sd},
          {"ci95", ci},          {"identifiable", identifiable},
          {"reason", reason},    {"free", same ? free[0] : free},
          {"interval", interval}};
}

json parameters_json(const Uncertainty& u) {
  const ParameterEstimate& eta = u.parameters[eta_index];
  return {{"sigma_a_per_mm", group(u, 0)},
          {"sigma_s_prime_per_mm", group(u, 3)},
          {"eta",
           {{"value", number(eta.value)},
            {"sd", number(eta.sd)},
            {"ci95", {number(eta.low), number(eta.high)}},
            {"identifiable", eta.identifiable},
            {"reason", eta.reason},
            {"interval", eta.interval},
            {"free", eta.free}}}};
}

json alpha_json(const Uncertainty& u) {
  json value, sd, ci, identifiable;
  for (const ParameterEstimate& e : u.alpha_prime) {
    value.push_back(number(e.value));
    sd.push_back(number(e.sd));
    ci.push_back({number(e.low), number(e.high)});
    identifiable.push_back(e.identifiable);
  }
  return {{"value", value}, {"sd", sd}, {"ci95", ci}, {"identifiable", identifiable}};
}

json matrix_json(const Eigen::MatrixXd& matrix) {
  json rows = json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(number(matrix(i, j)));
    rows.push_back(row);
  }
  return rows;
}

json starts_json(const Solution& solution) {
  json starts = json::array();
  for (const StartRecord& start : solution.starts) {
    json from, to, history;
    for (int i = 0; i < parameter_count; ++i) {
      from.push_back(number(natural_value(i, start.from[static_cast<std::size_t>(i)])));
      to.push_back(number(natural_value(i, start.to[static_cast<std::size_t>(i)])));
    }
    for (const double cost : start.history) history.push_back(number(cost));
    starts.push_back({{"from", from},
                      {"to", to},
                      {"cost", number(start.cost)},
                      {"converged", start.converged},
                      {"message", start.message},
                      {"cost_history", history}});
  }
  return starts;
}

json targets_json(const FitReport& report) {
  json targets = json::array();
  for (std::size_t i = 0; i < report.targets.size(); ++i) {
    const FittedTarget& t = report.targets[i];
    targets.push_back({{"scene", t.scene},
                       {"target", t.target},
                       {"operator_relative_error", number(t.operator_error.rms)},
                       {"operator_relative_error_at_most", number(t.operator_error.at_most)},
                       {"noise_sd", report.solution.noise_sd[i]},
                       {"noise_from", t.noise.source},
                       {"noise_read_sd", t.noise.read_sd},
                       {"noise_shot", t.noise.shot},
                       {"noise_relative_sd", t.noise.relative},
                       {"noise_channel_correlation", matrix_json(report.solution.noise_correlation[i])},
                       {"residual_neighbour_correlation", number(t.neighbour_correlation)},
                       {"scale", number(t.scale)},
                       {"saturated_pixels", t.saturated},
                       {"pixels_near_highlights", t.near_highlights},
                       {"counters", {{"done", t.counters.done}, {"skipped", t.counters.skipped}}}});
  }
  return targets;
}

/// RMS over targets and channels of the noise the residuals show.
double noise_sd(const Solution& solution) {
  double sum = 0;
  for (const auto& target : solution.noise_sd)
    for (const double sd : target) sum += sd * sd;
  return std::sqrt(sum / (3.0 * static_cast<double>(solution.noise_sd.size())));
}

json material_json(const Material& m) {
  return {{"sigma_a_per_mm", {m.sigma_a.r, m.sigma_a.g, m.sigma_a.b}},
          {"sigma_s_prime_per_mm", {m.sigma_s_prime.r, m.sigma_s_prime.g, m.sigma_s_prime.b}},
          {"g", m.g},
          {"eta", m.eta}};
}

}  // namespace

nlohmann::json fit_json(const FitReport& report) {
  json names = json::array();
  for (int i = 0; i < parameter_count; ++i) names.push_back(parameter_name(i));
  if (report.job.scale_free)
    for (std::size_t t = 0; t < report.targets.size(); ++t) names.push_back(fmt::format("ln scale[{}]", t + 1));
  const Solution& s = report.solution;
  json document = {
      {"format", "opaline-fit"},
      {"version", 1},
      {"model", report.job.model},
      {"material", report.material.name},
      {"parameters", parameters_json(report.uncertainty)},
      {"alpha_prime", alpha_json(report.uncertainty)},
      {"rmse", number(s.rmse)},
      {"relative_rmse", number(s.relative_rmse)},
      {"noise_sd", number(noise_sd(s))},
      {"correlation", matrix_json(report.uncertainty.correlation)},
      {"correlation_order", names},
      {"condition_number", number(report.uncertainty.condition)},
      {"notes", report.uncertainty.notes},
      {"starts", s.starts.size()},
      {"best_start", s.best_start},
      {"iterations", s.iterations},
      {"converged", s.converged},
      {"start_records", starts_json(s)},
      {"targets", targets_json(report)},
      {"seconds",
       {{"operator", report.operator_seconds}, {"solve", report.solve_seconds}, {"total", report.total_seconds}}}};
  document["determined"] = report.diagnosis.determined;
  document["refusal"] = report.diagnosis.refusal;
  document["chi_squared_per_value"] = number(s.chi_squared / std::max(s.freedom, 1.0));
  document["diagnosis"] = diagnosis_json(report.diagnosis);
  if (report.correction) document["correction"] = correction_json(*report.correction, names);
  if (report.surface) document["surface"] = surface_json(*report.surface);
  if (report.comparison) document["models"] = comparison_json(*report.comparison);
  if (report.repetitions) document["bootstrap"] = bootstrap_json(*report.repetitions, names);
  if (!report.advice.empty()) document["advice"] = advice_json(report.advice);
  return document;
}

Image signed_colours(const Image& difference, double scale) {
  Image out(difference.width, difference.height, {"R", "G", "B", "A"});
  for (std::size_t p = 0; p < difference.pixel_count(); ++p) {
    const float* d = &difference.data[p * 4];
    if (d[3] <= 0) continue;
    const double mean = static_cast<double>(d[0] + d[1] + d[2]) / 3, t = std::clamp(mean / scale, -1.0, 1.0);
    const double towards_red = t > 0 ? 1 : 1 + t, towards_blue = t < 0 ? 1 : 1 - t;
    out.data[p * 4] = static_cast<float>(towards_red);
    out.data[p * 4 + 1] = static_cast<float>(1 - std::abs(t));
    out.data[p * 4 + 2] = static_cast<float>(towards_blue);
    out.data[p * 4 + 3] = 1;
  }
  return out;
}

std::vector<std::string> write_fit(const FitReport& report, const std::string& directory, bool usable) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw InputError(directory, "", "the output folder cannot be made: " + error.message());
  std::vector<std::string> written;
  const auto place = [&](const std::string& name) {
    return written.emplace_back((std::filesystem::path(directory) / name).string());
  };
  for (std::size_t i = 0; i < report.targets.size(); ++i) {
    const FittedTarget& t = report.targets[i];
    const std::string suffix = report.targets.size() == 1 ? "" : fmt::format("_{}", i + 1);
    const double exposure = auto_exposure(t.picture);
    const std::map<std::string, std::string> header = {
        {"opaline:scene", t.scene}, {"opaline:target", t.target}, {"opaline:model", report.job.model}};
    write_exr(place("target" + suffix + ".exr"), t.picture, header);
    write_png(place("target" + suffix + ".png"), t.picture, exposure);
    write_exr(place("refit" + suffix + ".exr"), t.refit, header);
    write_png(place("refit" + suffix + ".png"), t.refit, exposure);
    write_exr(place("difference" + suffix + ".exr"), t.difference, header);
    write_png(place("difference" + suffix + ".png"),
              signed_colours(t.difference, 4 * std::max(noise_sd(report.solution), 1e-12)));
  }
  if (usable) write_text_atomically(place("material.json"), material_json(report.material).dump(2) + "\n");
  write_text_atomically(place("report.html"), fit_report_html(report));
  write_text_atomically(place("fit.json"), fit_json(report).dump(2) + "\n");
  return written;
}

}  // namespace opaline
