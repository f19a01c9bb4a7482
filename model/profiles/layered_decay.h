// How fast the light of a stack falls far from the beam: the singularity of its transforms nearest to the real axis.
#pragma once

#include "model/profiles/layered.h"

namespace opaline {

/// Whether the transforms at k = i kappa are still what they continue from k = 0: positive, no resonance passed.
inline bool regular(const std::vector<SlabSource<double>>& slabs, std::size_t count, double kappa_squared) {
  const Complex<double> p(-kappa_squared);
  Response<Complex<double>> all = slab_response(slabs.front(), p);
  for (std::size_t i = 1; i < count; ++i) {
    const Response<Complex<double>> next = slab_response(slabs[i], p);
    if (!(open_share(all, next).re > 0)) return false;
    all = stacked(all, next);
  }
  return true;
}

/// kappa_0^2 [1/mm^2] of the upper `count` slabs: R(r) falls like exp(-kappa_0 r). The slowest mode of the freest layer
/// bounds it from above; along the imaginary axis multiple reflection between layers only grows until it resonates, so
/// bisection finds it.
inline double decay_squared(const std::vector<SlabSource<double>>& slabs, std::size_t count) {
  double high = HUGE_VAL;
  for (std::size_t i = 0; i < count; ++i) {
    const SlabSource<double>& s = slabs[i];
    const double mode = s.infinite ? 0 : pi / s.period;
    high = std::min(high, s.sigma_tr_squared + mode * mode);
  }
  if (count == 1) return high;
  double low = 0, top = high * (1 - 1e-14);
  if (!(top > 0) || regular(slabs, count, top)) return std::max(top, 0.0);
  for (int i = 0; i < 200 && top - low > 1e-15 * top; ++i) {
    const double middle = 0.5 * (low + top);
    (regular(slabs, count, middle) ? low : top) = middle;
  }
  return low;
}

}  // namespace opaline
