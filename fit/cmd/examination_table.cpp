#include "fit/cmd/examination_table.h"

#include <fmt/format.h>

namespace opaline {
namespace {

std::string comparison_rows(const ModelComparison& comparison) {
  std::string text = fmt::format("\n{:<29}{:>9}{:>11}  {:<30}{:<28}eta\n", "model", "residual", "d BIC",
                                 "sigma_a [1/mm]", "sigma_s' [1/mm]");
  for (const ModelFit& m : comparison.models) {
    if (!m.same_as.empty()) {
      text += fmt::format("{:<29}as {}\n", m.name, m.same_as);
      continue;
    }
    const auto value = [&](std::size_t i) { return m.uncertainty.parameters[i].value; };
    text += fmt::format("{:<29}{:>9.3g}{:>11.4g}  {:<30}{:<28}{:.4g}{}\n", m.name, m.solution.relative_rmse,
                        m.delta_bic, fmt::format("{:.4g} {:.4g} {:.4g}", value(0), value(1), value(2)),
                        fmt::format("{:.4g} {:.4g} {:.4g}", value(3), value(4), value(5)), value(6),
                        m.solution.converged ? "" : "  NOT CONVERGED");
  }
  for (const std::string& reason : comparison.left_out) text += "left out: " + reason + "\n";
  for (const std::string& warning : comparison.warnings) text += "warning: " + warning + "\n";
  return text + fmt::format("compared in {:.2f} s\n", comparison.seconds);
}

std::string correction_rows(const FitReport& report) {
  const Correction& c = *report.correction;
  std::string text =
      fmt::format("\ncorrected by {}: {} renders in {:.1f} s{}\n", report.job.reference->technique, c.renders,
                  c.seconds, c.renders_saved > 0 ? fmt::format(" ({} saved: near enough)", c.renders_saved) : "");
  for (std::size_t i = 0; i < c.steps.size(); ++i)
    text += fmt::format(
        "  step {}: residual {:.3g} of the picture, operator off by {:.2g}, {}next step {:.2g} standard deviations\n",
        i + 1, c.steps[i].residual, c.steps[i].defect, c.steps[i].better ? "" : "no better, went back, ",
        c.steps[i].next_step_sd);
  return text;
}

std::string bootstrap_rows(const FitReport& report) {
  const Bootstrap& b = *report.repetitions;
  std::string text =
      fmt::format("\n{} repetitions in {:.2f} s ({} failed): 95 % of them\n", b.draws.rows(), b.seconds, b.failed);
  for (int i = 0; i < parameter_count; ++i)
    if (report.uncertainty.parameters[static_cast<std::size_t>(i)].free)
      text += fmt::format("{:<24}{:.5g} .. {:.5g}\n", parameter_name(i), natural_value(i, b.low[i]),
                          natural_value(i, b.high[i]));
  return text;
}

std::string advice_rows(const std::vector<Advice>& advice) {
  std::string text = "\nwhat another picture would do to the intervals (geometric mean over the free parameters)\n";
  for (const Advice& a : advice) text += fmt::format("  {:>8.3g} times narrower: {}\n", a.factor, a.what);
  return text;
}

}  // namespace

std::string examination_table(const FitReport& report) {
  std::string text;
  if (report.correction) text += correction_rows(report);
  if (report.comparison) text += comparison_rows(*report.comparison);
  if (report.repetitions) text += bootstrap_rows(report);
  if (!report.advice.empty()) text += advice_rows(report.advice);
  return text;
}

}  // namespace opaline
