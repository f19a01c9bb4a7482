#include "fit/report/fit_report.h"

#include "fit/report/svg.h"
#include "model/profiles/profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

constexpr const char* colours[] = {"#c33", "#3a3", "#36c"};

std::string pictures(const FitReport& report) {
  std::string html = "<h3>Target, refit, difference (blue: refit too dark, red: too bright; saturated at 4 sd)</h3>\n";
  for (std::size_t i = 0; i < report.targets.size(); ++i) {
    const std::string suffix = report.targets.size() == 1 ? "" : fmt::format("_{}", i + 1);
    html += fmt::format("<figure><figcaption>{}</figcaption>", svg::escaped(report.targets[i].target));
    for (const char* name : {"target", "refit", "difference"})
      html += fmt::format("<img src='{0}{1}.png' alt='{0}' width='280'/> ", name, suffix);
    html += "</figure>\n";
  }
  return html;
}

/// Residuals of all targets in units of their noise.
std::vector<double> scaled_residuals(const FitReport& report) {
  std::vector<double> all;
  for (std::size_t t = 0; t < report.targets.size(); ++t) {
    const FittedTarget& target = report.targets[t];
    for (std::size_t p = 0; p < target.difference.pixel_count(); ++p) {
      if (!(target.difference.data[4 * p + 3] > 0)) continue;
      for (std::size_t c = 0; c < (report.solution.grey ? 1u : 3u); ++c) {
        const double sd = target.noise.known
                              ? std::sqrt(target.noise.variance(static_cast<int>(c),
                                                                static_cast<double>(target.refit.data[4 * p + c])))
                              : report.solution.noise_sd[t][c];
        all.push_back(static_cast<double>(target.difference.data[4 * p + c]) / std::max(sd, 1e-300));
      }
    }
  }
  return all;
}

std::string histogram(const FitReport& report) {
  const std::vector<double> all = scaled_residuals(report);
  constexpr int bins = 50;
  constexpr double reach = 5, step = 2 * reach / bins;
  std::vector<double> counts(bins, 0.0);
  std::size_t outside = 0;
  for (const double r : all) {
    if (std::abs(r) < reach)
      counts[static_cast<std::size_t>((r + reach) / step)] += 1 / (static_cast<double>(all.size()) * step);
    else
      ++outside;
  }
  svg::Points bars, normal;
  double most = 0.45;
  for (int i = 0; i < bins; ++i) {
    const double x = -reach + (i + 0.5) * step, n = std::exp(-x * x / 2) / std::sqrt(2 * pi);
    bars.emplace_back(x, counts[static_cast<std::size_t>(i)]);
    normal.emplace_back(x, n);
    most = std::max(most, 1.05 * counts[static_cast<std::size_t>(i)]);
  }
  svg::Plot plot({"residual / noise sd", -reach, reach, false}, {"density", 0, most, false});
  plot.bars(bars, step, "#888");
  plot.line(normal, "#000");
  return fmt::format("<h3>Residual against its noise (line: normal; {} of {} values beyond 5 sd)</h3>\n", outside,
                     all.size()) +
         plot.text("histogram of the residual in units of the noise");
}

/// Relative sd of R(r) of channel c, to first order.
double relative_band(const ProfileGradient& g, const Medium<double>& m, const Eigen::MatrixXd& covariance, int c) {
  Eigen::Vector3d d(m.sigma_a * g.d_sigma_a, m.sigma_s_prime * g.d_sigma_s_prime, g.d_eta);
  d /= g.value;
  const int at[] = {c, c + 3, eta_index};
  double variance = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) variance += d[i] * d[j] * covariance(at[i], at[j]);
  return std::sqrt(std::max(variance, 0.0));
}

std::string profile_plot(const FitReport& report) {
  const ProfileInfo& info = *find_profile(report.job.model);
  std::vector<std::array<svg::Points, 3>> curves;
  double low = HUGE_VAL, high = 0;
  double r_high = 0;
  for (int c = 0; c < 3; ++c)
    r_high = std::max(r_high, 30 / (report.material.sigma_a[c] + report.material.sigma_s_prime[c]));
  for (int c = 0; c < (report.solution.grey ? 1 : 3); ++c) {
    const Medium<double> medium = report.material.channel(c);
    const auto profile = info.make(medium);
    std::array<svg::Points, 3> curve;
    for (int i = 0; i <= 80; ++i) {
      const double r = r_high * std::pow(10.0, -3.5 * (1 - i / 80.0));
      const ProfileGradient g = profile->evaluate_with_gradient(r);
      if (!(g.value > 0)) continue;
      const double band = std::min(1.96 * relative_band(g, medium, report.uncertainty.covariance, c), 5.0);
      curve[0].emplace_back(r, g.value);
      curve[1].emplace_back(r, g.value * std::exp(-band));
      curve[2].emplace_back(r, g.value * std::exp(band));
      low = std::min(low, g.value), high = std::max(high, g.value);
    }
    curves.push_back(curve);
  }
  low = std::max(low, 1e-8 * high);
  if (!(high > low)) return "";
  svg::Plot plot({"r [mm]", r_high * std::pow(10.0, -3.5), r_high, true}, {"R [1/mm^2]", low, 2 * high, true});
  for (std::size_t c = 0; c < curves.size(); ++c) {
    plot.band(curves[c][1], curves[c][2], colours[c]);
    plot.line(curves[c][0], colours[c]);
  }
  return "<h3>Recovered profile with its 95 % band</h3>\n" + plot.text("profile R(r) per channel");
}

std::string cell(const std::string& text) { return "<td>" + svg::escaped(text) + "</td>"; }

std::string parameter_table(const FitReport& report) {
  std::string html =
      "<h3>Parameters</h3>\n<table><tr><th>parameter</th><th>value</th><th>sd</th><th>95 % interval</th><th>how</th>"
      "<th>determined</th></tr>\n";
  for (int i = 0; i < parameter_count; ++i) {
    const ParameterEstimate& e = report.uncertainty.parameters[static_cast<std::size_t>(i)];
    html += "<tr>" + cell(parameter_name(i)) + cell(e.identifiable ? fmt::format("{:.6g}", e.value) : "-") +
            cell(e.free ? fmt::format("{:.2g}", e.sd) : "-") +
            cell(e.free ? fmt::format("{:.5g} .. {:.5g}", e.low, e.high) : "fixed") + cell(e.free ? e.interval : "-") +
            cell(e.identifiable ? "yes" : "no: " + e.reason) + "</tr>\n";
  }
  return html + "</table>\n";
}

std::string correlations(const FitReport& report) {
  const Eigen::MatrixXd& r = report.uncertainty.correlation;
  std::vector<std::vector<double>> values;
  std::vector<std::string> names;
  for (Eigen::Index i = 0; i < r.rows(); ++i) {
    names.push_back(i < parameter_count ? parameter_name(static_cast<int>(i))
                                        : fmt::format("ln scale[{}]", i - parameter_count + 1));
    std::vector<double> row;
    for (Eigen::Index j = 0; j < r.cols(); ++j) row.push_back(r(i, j));
    values.push_back(row);
  }
  return fmt::format("<h3>Correlations (condition number {:.3g})</h3>\n", report.uncertainty.condition) +
         svg::matrix(values, names, "correlation of the parameters");
}

std::string convergence(const FitReport& report) {
  double low = HUGE_VAL, high = 0, longest = 1;
  for (const StartRecord& s : report.solution.starts) {
    longest = std::max(longest, static_cast<double>(s.history.size()));
    for (const double cost : s.history)
      if (cost > 0) low = std::min(low, cost), high = std::max(high, cost);
  }
  if (!(high > 0)) return "";
  low = std::max(low, 1e-12 * high);
  svg::Plot plot({"iteration", 0, longest, false}, {"half the sum of squares", 0.8 * low, 1.25 * high, true});
  for (std::size_t i = 0; i < report.solution.starts.size(); ++i) {
    svg::Points points;
    const StartRecord& s = report.solution.starts[i];
    for (std::size_t k = 0; k < s.history.size(); ++k) points.emplace_back(k, std::max(s.history[k], low));
    plot.line(points, static_cast<int>(i) == report.solution.best_start ? "#000" : "#69b",
              static_cast<int>(i) == report.solution.best_start ? 2 : 1);
  }
  std::size_t converged = 0, same = 0;
  for (const StartRecord& s : report.solution.starts) converged += s.converged, same += s.excess < 1.92;
  if (report.correction)
    return fmt::format("<h3>Starts of the fit before its correction: {} of {} converged (black: the best)</h3>\n",
                       converged, report.solution.starts.size()) +
           plot.text("cost of every start");
  return fmt::format("<h3>Starts: {} of {} converged, {} to a fit as good as the best (black)</h3>\n", converged,
                     report.solution.starts.size(), same) +
         plot.text("cost of every start");
}

std::string models(const ModelComparison& comparison) {
  std::string html =
      "<h3>Other models on the same operator</h3>\n<table><tr><th>model</th><th>residual</th><th>d BIC</th><th>sigma_a "
      "[1/mm]</th><th>sigma_s' [1/mm]</th><th>eta</th></tr>\n";
  for (const ModelFit& m : comparison.models) {
    if (!m.same_as.empty()) {
      html += "<tr>" + cell(m.name) + "<td colspan='5'>as " + svg::escaped(m.same_as) + "</td></tr>\n";
      continue;
    }
    const auto value = [&](std::size_t i) { return m.uncertainty.parameters[i].value; };
    html += "<tr>" + cell(m.name) + cell(fmt::format("{:.3g}", m.solution.relative_rmse)) +
            cell(fmt::format("{:.4g}", m.delta_bic)) +
            cell(fmt::format("{:.4g} {:.4g} {:.4g}", value(0), value(1), value(2))) +
            cell(fmt::format("{:.4g} {:.4g} {:.4g}", value(3), value(4), value(5))) +
            cell(fmt::format("{:.4g}", value(6))) + "</tr>\n";
  }
  html += "</table>\n";
  for (const std::string& w : comparison.warnings) html += "<p class='warning'>" + svg::escaped(w) + "</p>\n";
  return html;
}

std::string words(const FitReport& report) {
  std::string html;
  if (!report.diagnosis.determined) html += "<p class='refusal'>" + svg::escaped(report.diagnosis.refusal) + "</p>\n";
  for (const std::string& note : report.uncertainty.notes) html += "<p class='note'>" + svg::escaped(note) + "</p>\n";
  for (const Advice& a : report.advice)
    html += fmt::format("<p class='advice'>{:.3g} times narrower with {}</p>\n", a.factor, svg::escaped(a.what));
  return html;
}

}  // namespace

std::string fit_report_html(const FitReport& report) {
  std::string html = fmt::format("<section class='opaline-fit'>\n<h2>Fit of {} with {}</h2>\n",
                                 svg::escaped(report.material.name), svg::escaped(report.job.model));
  html +=
      fmt::format("<p>Residual {:.3g} of the picture (rms), chi-squared {:.3g} per value.</p>\n",
                  report.solution.relative_rmse, report.solution.chi_squared / std::max(report.solution.freedom, 1.0));
  html += words(report) + parameter_table(report) + pictures(report) + histogram(report) + profile_plot(report) +
          correlations(report) + convergence(report);
  if (report.comparison) html += models(*report.comparison);
  return html + "</section>\n";
}

}  // namespace opaline
