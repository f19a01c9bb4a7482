#include "model/profiles/tabulated_profile.h"

#include "model/profiles/inverse.h"
#include "model/quadrature.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

namespace opaline {
namespace {

void check(const std::vector<ProfileSample>& samples) {
  if (samples.size() < 2) throw ProfileTableError(0, "a profile needs at least two samples");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const int line = static_cast<int>(i) + 1;
    if (!(samples[i].r > 0 && std::isfinite(samples[i].r))) throw ProfileTableError(line, "r must be positive [mm]");
    if (!(samples[i].value > 0 && std::isfinite(samples[i].value)))
      throw ProfileTableError(line, "R must be positive [1/mm^2]");
    if (i > 0 && !(samples[i].r > samples[i - 1].r)) throw ProfileTableError(line, "r must rise from line to line");
  }
  if (!(samples.back().value < samples[samples.size() - 2].value))
    throw ProfileTableError(static_cast<int>(samples.size()), "R must fall towards the end");
}

/// Fritsch & Butland's slope at the node between secants a and b over widths h and k: their weighted harmonic mean.
double monotone_slope(double a, double b, double h, double k) {
  if (a * b <= 0) return 0;
  const double share = (h + 2 * k) / (3 * (h + k));
  return a * b / (share * b + (1 - share) * a);
}

}  // namespace

TabulatedProfile::TabulatedProfile(std::vector<ProfileSample> samples) : samples_(std::move(samples)) {
  check(samples_);
  for (const ProfileSample& s : samples_) nodes_.push_back({std::log(s.r), std::log(s.value), 0, 0});
  const std::size_t last = nodes_.size() - 1;
  const auto width = [&](std::size_t i) { return nodes_[i + 1].log_r - nodes_[i].log_r; };
  const auto secant = [&](std::size_t i) { return (nodes_[i + 1].log_value - nodes_[i].log_value) / width(i); };
  for (std::size_t i = 1; i < last; ++i) {
    nodes_[i].slope = monotone_slope(secant(i - 1), secant(i), width(i - 1), width(i));
  }
  nodes_[last].slope = secant(last - 1);  // the first one is 0: the core is flat
  decay_ = -nodes_[last].slope / samples_.back().r;
  nodes_[0].cumulative = pi * samples_[0].value * samples_[0].r * samples_[0].r;
  for (std::size_t i = 0; i < last; ++i) nodes_[i + 1].cumulative = cumulative_in(i, nodes_[i + 1].log_r);
  const double r = samples_.back().r;
  total_ = nodes_[last].cumulative + 2 * pi * samples_.back().value * (r + 1 / decay_) / decay_;
}

/// log R in interval i, cubic Hermite.
double TabulatedProfile::between(std::size_t i, double log_r) const {
  const Node &a = nodes_[i], &b = nodes_[i + 1];
  const double h = b.log_r - a.log_r, t = (log_r - a.log_r) / h, u = 1 - t;
  return u * u * ((1 + 2 * t) * a.log_value + t * h * a.slope) + t * t * ((1 + 2 * u) * b.log_value - u * h * b.slope);
}

double TabulatedProfile::cumulative_in(std::size_t i, double log_r) const {
  const auto ring = [&](double y) { return 2 * pi * std::exp(2 * y + between(i, y)); };
  return nodes_[i].cumulative + gauss_legendre(nodes_[i].log_r, log_r, ring);
}

double TabulatedProfile::evaluate(double r) const {
  if (r <= samples_.front().r) return samples_.front().value;
  if (r >= samples_.back().r) return samples_.back().value * std::exp(-decay_ * (r - samples_.back().r));
  const auto above = std::ranges::upper_bound(samples_, r, {}, &ProfileSample::r);
  return std::exp(between(static_cast<std::size_t>(above - samples_.begin()) - 1, std::log(r)));
}

double TabulatedProfile::cumulative(double r) const {
  if (r <= samples_.front().r) return pi * samples_.front().value * r * r;
  const double last = samples_.back().r;
  if (r >= last) {
    const double beyond = (std::min(r, 1e150) + 1 / decay_) * std::exp(-decay_ * (r - last)) / decay_;
    return total_ - 2 * pi * samples_.back().value * beyond;
  }
  const auto above = std::ranges::upper_bound(samples_, r, {}, &ProfileSample::r);
  return cumulative_in(static_cast<std::size_t>(above - samples_.begin()) - 1, std::log(r));
}

double TabulatedProfile::sample(double xi) const {
  return invert_share([&](double r) { return cumulative(r) / total_; },
                      [&](double r) { return 2 * pi * r * evaluate(r) / total_; }, samples_.front().r, xi);
}

namespace {

std::string_view trimmed(std::string_view s) {
  const auto first = s.find_first_not_of(" \t\r"), last = s.find_last_not_of(" \t\r");
  return first == s.npos ? std::string_view{} : s.substr(first, last - first + 1);
}

std::optional<double> number(std::string_view s) {
  double value = 0;
  const auto [end, error] = std::from_chars(s.data(), s.data() + s.size(), value);
  return error == std::errc{} && end == s.data() + s.size() ? std::optional(value) : std::nullopt;
}

}  // namespace

std::vector<ProfileSample> parse_profile_csv(std::string_view text) {
  std::vector<ProfileSample> samples;
  std::vector<int> lines;
  bool header_allowed = true;
  for (int line = 1; !text.empty(); ++line) {
    const auto end = text.find('\n');
    const std::string_view row = trimmed(text.substr(0, end));
    text = end == text.npos ? std::string_view{} : text.substr(end + 1);
    if (row.empty() || row.front() == '#') continue;
    const auto comma = row.find(',');
    if (comma == row.npos) throw ProfileTableError(line, "expected two columns: r_mm,R_per_mm2");
    const auto r = number(trimmed(row.substr(0, comma))), value = number(trimmed(row.substr(comma + 1)));
    if (r && value) {
      samples.push_back({*r, *value});
      lines.push_back(line);
    } else if (!header_allowed) {
      throw ProfileTableError(line, "not two numbers: " + std::string(row));
    }
    header_allowed = false;
  }
  try {
    check(samples);
  } catch (const ProfileTableError& e) {
    throw ProfileTableError(e.line > 0 ? lines[static_cast<std::size_t>(e.line) - 1] : 0, e.what());
  }
  return samples;
}

}  // namespace opaline
