#include "model/profiles/cumulative_table.h"

#include "model/chebyshev.h"
#include "model/check.h"
#include "model/conventions.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

constexpr double width = 0.5;      // of a segment, in log r
constexpr double first = -12;      // below exp(first) core the profile is constant to 4e-11 of the flux there
constexpr int most_segments = 96;  // up to 4e15 cores: what lies beyond a tail r^-3 is below 1e-15

/// Chebyshev coefficients of f on [-1, 1]; the last one is 0.
template <typename Coefficients, typename F>
Coefficients chebyshev(const F& f) {
  Coefficients a{};
  chebyshev_fit(CumulativeTable::points, f, a);
  return a;
}

/// int_-1^x of the polynomial.
template <typename Coefficients>
Coefficients integral(const Coefficients& a) {
  Coefficients c{};
  for (std::size_t k = 1; k < a.size(); ++k) {
    const double after = k + 1 < a.size() ? a[k + 1] : 0, before = a[k - 1] * (k == 1 ? 2 : 1);
    c[k] = (before - after) / (2.0 * static_cast<double>(k));
    c[0] += k % 2 ? c[k] : -c[k];
  }
  return c;
}

}  // namespace

CumulativeTable::CumulativeTable(const std::function<double(double)>& profile, double core_radius)
    : core_(core_radius), centre_(pi * profile(0)) {
  OPALINE_CHECK(core_radius > 0);
  const double edge = core_ * std::exp(first);
  starts_ = {centre_ * edge * edge};
  for (int i = 0; i < most_segments; ++i) {
    const auto density = [&](double x) {
      const double r = core_ * std::exp(first + width * (i + 0.5 * (x + 1)));
      return 0.5 * width * 2 * pi * (r * profile(r)) * r;
    };
    densities_.push_back(chebyshev<Coefficients>(density));
    segments_.push_back(integral(densities_.back()));
    const double rise = std::max(0.0, clenshaw(segments_.back(), 1.0)), start = starts_.back();
    starts_.push_back(start + rise);
    if (i > 40 && rise <= 1e-18 * start) break;
  }
}

double CumulativeTable::cumulative(double r) const {
  if (r <= core_ * std::exp(first)) return centre_ * r * r;
  const double position = (std::log(r / core_) - first) / width, whole = std::floor(position);
  if (!(whole < static_cast<double>(segments_.size()))) return total();
  const std::size_t i = static_cast<std::size_t>(std::max(0.0, whole));
  return std::clamp(starts_[i] + clenshaw(segments_[i], 2 * (position - whole) - 1), starts_[i], starts_[i + 1]);
}

double CumulativeTable::sample(double xi) const {
  const double target = xi * total();
  if (!(target > 0)) return 0;
  if (target <= starts_.front()) return std::sqrt(target / centre_);
  const auto above = std::lower_bound(starts_.begin() + 1, starts_.end() - 1, target);
  const std::size_t i = static_cast<std::size_t>(above - starts_.begin()) - 1;
  double low = -1, high = 1, x = 0;
  for (int step = 0; step < 60 && high - low > 1e-15; ++step) {
    const double excess = starts_[i] + clenshaw(segments_[i], x) - target, slope = clenshaw(densities_[i], x);
    (excess < 0 ? low : high) = x;
    double next = x - excess / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double moved = std::abs(next - x);
    x = next;
    if (moved < 1e-14) break;
  }
  return core_ * std::exp(first + width * (static_cast<double>(i) + 0.5 * (x + 1)));
}

}  // namespace opaline
