#include "fit/diagnosis.h"

#include <fmt/format.h>

#include <cmath>

namespace opaline {
namespace {

/// Relative sd of a quantity with d ln q = a d ln sigma_a + s d ln sigma_s'.
double relative_sd(const Eigen::MatrixXd& covariance, int c, double a, double s) {
  const double variance =
      a * a * covariance(c, c) + s * s * covariance(c + 3, c + 3) + 2 * a * s * covariance(c, c + 3);
  return std::sqrt(std::max(variance, 0.0));
}

std::vector<Derived> quantities(const Solution& solution, const Uncertainty& u, int c) {
  const double sigma_a = std::exp(solution.parameters[static_cast<std::size_t>(c)]),
               sigma_s = std::exp(solution.parameters[static_cast<std::size_t>(c) + 3]);
  const double sigma_t = sigma_a + sigma_s, share = sigma_a / sigma_t;
  return {{"sigma_t'", sigma_t, relative_sd(u.covariance, c, share, 1 - share)},
          {"sigma_tr", std::sqrt(3 * sigma_a * sigma_t),
           relative_sd(u.covariance, c, 0.5 * (1 + share), 0.5 * (1 - share))},
          // Relative to 1 - alpha': what tells materials apart.
          {"alpha'", sigma_s / sigma_t, relative_sd(u.covariance, c, sigma_s / sigma_t, -sigma_s / sigma_t)}};
}

constexpr double known = 0.2;  // relative sd below which a quantity is called determined

std::string sentence_of(const std::vector<Derived>& q, const Uncertainty& u, int c) {
  const bool a = u.parameters[static_cast<std::size_t>(c)].identifiable,
             s = u.parameters[static_cast<std::size_t>(c) + 3].identifiable;
  if (a && s) return "both coefficients";
  const bool size = q[0].relative_sd < known, reach = q[1].relative_sd < known, albedo = q[2].relative_sd < known;
  if (s) return "sigma_s' but not sigma_a: too little light comes from far enough to show absorption";
  if (a) return "sigma_a but not sigma_s': the pictures are too coarse for the mean free path, or too dark";
  if (albedo && !size && !reach)
    return "the albedo alpha' only: light and view look alike at every point, so no length shows";
  if (reach && !size)
    return "the reach 1/sigma_tr only: the near field, which tells the coefficients apart, is not seen";
  if (size && !albedo) return "the mean free path only: nothing tells how much is absorbed";
  return "neither coefficient";
}

std::string remedy(const Diagnosis& d, const Uncertainty& u) {
  bool albedo_only = true, any = false;
  for (const ChannelDiagnosis& c : d.channels) albedo_only &= c.sentence.rfind("the albedo alpha' only", 0) == 0;
  for (const ParameterEstimate& e : u.parameters) any |= e.reason.find("bound") != std::string::npos;
  if (albedo_only) return "add a beam, an edge or a side light; or fix what you know with --free or --prior";
  if (any)
    return "check scale and light of the scene, fix what you know with --free or --prior, or add pictures (--advise)";
  return "fix what you know with --free or --prior, or add pictures: --advise says which";
}

}  // namespace

Diagnosis diagnose(const Solution& solution, const Uncertainty& u) {
  Diagnosis d;
  const char* names[] = {"R", "G", "B"};
  for (int c = 0; c < (solution.grey ? 1 : 3); ++c) {
    ChannelDiagnosis channel;
    channel.quantities = quantities(solution, u, c);
    channel.sentence = sentence_of(channel.quantities, u, c);
    d.channels.push_back(std::move(channel));
  }
  std::string lost;
  for (int i = 0; i < parameter_count; ++i) {
    const ParameterEstimate& e = u.parameters[static_cast<std::size_t>(i)];
    if (!e.free || e.identifiable || (solution.grey && i < eta_index && i % 3 != 0)) continue;
    d.determined = false;
    lost += fmt::format("{}{} ({})", lost.empty() ? "" : "; ", parameter_name(i), e.reason);
  }
  if (d.determined) return d;
  d.refusal = "the pictures do not determine " + lost + ".";
  for (std::size_t c = 0; c < d.channels.size(); ++c)
    if (!u.parameters[c].identifiable || !u.parameters[c + 3].identifiable)
      d.refusal += fmt::format(" In {} they determine {}.", solution.grey ? "grey" : names[c], d.channels[c].sentence);
  d.refusal += " To get a number, " + remedy(d, u) + ".";
  return d;
}

}  // namespace opaline
