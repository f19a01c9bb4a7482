#include "fit/cmd/fit_table.h"

#include "fit/cmd/examination_table.h"
#include "render/scene/json_object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// As many digits as the standard deviation leaves meaningful and one more, 3 to 9.
std::string digits(double value, double sd) {
  if (!std::isfinite(value)) return "-";
  const double ratio = sd > 0 && value != 0 ? std::abs(value) / sd : 1e3;
  return fmt::format("{:.{}g}", value, std::clamp(static_cast<int>(std::ceil(std::log10(ratio))) + 1, 3, 9));
}

std::string row(int i, const ParameterEstimate& e, const std::optional<ParameterVector>& truth) {
  const std::string interval = e.free ? fmt::format("{} .. {}", digits(e.low, e.sd), digits(e.high, e.sd)) : "fixed";
  std::string line = fmt::format("{:<24}", parameter_name(i));
  const double value = truth ? natural_value(i, (*truth)[static_cast<std::size_t>(i)]) : 0;
  if (truth) line += fmt::format("{:>12}", digits(value, 0));
  if (!e.identifiable) return line + fmt::format("{:>12}  {:<22}  not determined: {}\n", "-", interval, e.reason);
  line += fmt::format("{:>12}  {:<22}", digits(e.value, e.sd), interval);
  if (truth) line += fmt::format("{:>+9.2f} %", 100 * (e.value - value) / value);
  if (truth && e.free && e.sd > 0) line += fmt::format("{:>+8.1f}", (e.value - value) / e.sd);
  return line + "\n";
}

std::string alpha_rows(const FitReport& report, const std::optional<ParameterVector>& truth) {
  std::string text;
  for (int c = 0; c < 3; ++c) {
    const ParameterEstimate& e = report.uncertainty.alpha_prime[static_cast<std::size_t>(c)];
    text += fmt::format("{:<24}", fmt::format("alpha'[{}] (derived)", "RGB"[c]));
    if (truth) {
      const double d = (*truth)[static_cast<std::size_t>(c)] - (*truth)[static_cast<std::size_t>(c) + 3];
      text += fmt::format("{:>12}", digits(1 / (1 + std::exp(d)), e.sd));
    }
    text += fmt::format("{:>12}  {} .. {}\n", digits(e.value, e.sd), digits(e.low, e.sd), digits(e.high, e.sd));
  }
  return text;
}

}  // namespace

ParameterVector read_truth(const std::string& path) {
  const nlohmann::json document = read_json_file(path);
  JsonObject root(document, path, "");
  JsonObject parameters = root.object("parameters");
  Material material;
  material.sigma_a = parameters.rgb("sigma_a_per_mm", Range::non_negative());
  material.sigma_s_prime = parameters.rgb("sigma_s_prime_per_mm", Range::non_negative());
  material.eta = parameters.number("eta", Range::positive());
  return to_parameters(material, {});
}

std::string truth_warning(const std::string& path, const std::string& model) {
  const std::string profile = read_json_file(path).value("profile", model);
  if (profile == model) return "";
  if (profile.empty())
    return "the dataset is transport through the shape itself: what the planar profile leaves out shows in the errors";
  return fmt::format("the dataset was rendered with {}; fitted with {}, the true values are not to be expected",
                     profile, model);
}

std::string fit_table(const FitReport& report, const std::optional<ParameterVector>& truth) {
  std::string text = fmt::format("{:<24}", "parameter") + (truth ? fmt::format("{:>12}", "true") : "") +
                     fmt::format("{:>12}  {:<22}", "recovered", "95 % interval") + (truth ? "      error  (sd)" : "") +
                     "\n";
  for (int i = 0; i < parameter_count; ++i)
    text += row(i, report.uncertainty.parameters[static_cast<std::size_t>(i)], truth);
  text += alpha_rows(report, truth);
  const Solution& s = report.solution;
  double worst_operator = 0;
  for (const FittedTarget& t : report.targets) worst_operator = std::max(worst_operator, t.operator_error.rms);
  text +=
      fmt::format("residual {:.3g} of the picture (rms); operator's own error {:.1g}; {} starts, {} iterations{}\n",
                  s.relative_rmse, worst_operator, s.starts.size(), s.iterations, s.converged ? "" : "; NOT CONVERGED");
  text += fmt::format("seconds: operator {:.2f}, solve {:.2f}, total {:.2f}\n", report.operator_seconds,
                      report.solve_seconds, report.total_seconds);
  if (report.job.scale_free)
    for (std::size_t t = 0; t < report.targets.size(); ++t)
      text += fmt::format("scale[{}] {:.4g} (sd {:.2g} %)\n", t + 1, report.targets[t].scale,
                          100 * report.uncertainty.scale_sd[t]);
  text += examination_table(report);
  for (const std::string& note : report.uncertainty.notes) text += "note: " + note + "\n";
  return text;
}

}  // namespace opaline
