// Inversion of a cumulative, for profiles whose closed form has no closed inverse.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace opaline {

/// The r > 0 with share(r) = xi for an increasing share with share(0) = 0 and density d(share)/dr, within 1e-14
/// relative as far as share's own digits go. `start` > 0 is a guess. Newton's method in log r inside a bracket, at
/// most a factor of 4 a step, bisection when a step leaves the bracket. xi <= 0 gives 0; a share that never
/// reaches xi gives a large r.
template <typename Share, typename Density>
double invert_share(const Share& share, const Density& density, double start, double xi) {
  if (!(xi > 0)) return 0;
  double low = 0, high = std::numeric_limits<double>::infinity(), r = start;
  for (int i = 0; i < 400 && r < 1e150; ++i) {
    const double excess = share(r) - xi;
    (excess < 0 ? low : high) = r;
    const double slope = density(r) * r;
    const double step = slope > 0 ? std::clamp(-excess / slope, -1.4, 1.4) : (excess < 0 ? 1.4 : -1.4);
    double next = r * std::exp(step);
    const bool inside = next > low && next < high;
    if (!inside) next = std::sqrt(std::max(low, 1e-300)) * std::sqrt(high);
    const double moved = std::abs(next - r);
    r = next;
    if (moved <= (inside ? 1e-9 : 1e-15) * r) break;  // Newton is quadratic: the next step is below the rounding
  }
  return r;
}

}  // namespace opaline
