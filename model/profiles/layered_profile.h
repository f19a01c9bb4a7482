// A stack of layers as a Profile: Hankel transforms of layered.h, inverted into heat kernels.
//
// Relative error 1e-11 until R has fallen by exp(-300), and of a transmittance of 1e-10 1e-8; total and
// total_transmittance are closed. What passes through
// thin layers unscattered (slab.h) is no diffuse light and not in the transmittance.
#pragma once

#include "model/profiles/heat_kernels.h"
#include "model/profiles/layered_decay.h"

namespace opaline {

/// The share of the beam that crosses the whole stack unscattered; 0 with an infinite layer.
template <typename T>
T straight_through(const std::vector<SlabSource<T>>& slabs) {
  T share = T(1.0);
  for (const SlabSource<T>& s : slabs) share *= s.infinite ? T(0.0) : s.unscattered;
  return share;
}

/// decay_squared of the upper 1, 2, ... slabs.
inline std::vector<double> decays(const std::vector<SlabSource<double>>& slabs) {
  std::vector<double> all;
  for (std::size_t count = 1; count <= slabs.size(); ++count) all.push_back(decay_squared(slabs, count));
  return all;
}

/// The first slab's kernels. phi is that of -(1 - R~) too, which keeps its digits where R~ is close to 1.
template <typename T>
std::vector<HeatKernel<T>> first_kernels(const SlabSource<T>& slab, double decay) {
  const auto reflected = [&](double p) { return value_of(slab_response(slab, Complex<T>(T(p))).reflected.re); };
  const double total = reflected(0);
  double bright_from = total > 0.5 ? value_of(slab.depth) * value_of(slab.depth) : HUGE_VAL;
  while (bright_from < 1e300 && reflected(1 / bright_from) < 0.5) bright_from *= 4;
  const auto transform = [&](const Complex<T>& p, double t) {
    const Response<Complex<T>> all = slab_response(slab, p);
    return t > bright_from ? -(all.absorbed + all.transmitted) : all.reflected;
  };
  return heat_kernels<T>(transform, value_of(slab.depth), decay, total);
}

/// Heat kernels of R(r): of the first slab, then of what each further one adds. Apart, because what comes from deep
/// down may be as faint as it lasts long, and would lose its digits beside what comes from the top.
template <typename T>
std::vector<HeatKernel<T>> reflectance_kernels(const std::vector<SlabSource<T>>& slabs,
                                               const std::vector<double>& decay) {
  std::vector<HeatKernel<T>> kernels = first_kernels(slabs.front(), decay.front());
  double depth = 0;
  for (std::size_t i = 1; i < slabs.size(); ++i) {
    depth += 2 * value_of(slabs[i - 1].below);
    const auto transform = [&](const Complex<T>& p, double = 0) {
      return added_reflectance(stack_response(slabs, p, i), slab_response(slabs[i], p));
    };
    const double added = value_of(transform(Complex<T>(T(0.0))).re);
    const auto more = heat_kernels<T>(transform, depth + value_of(slabs[i].depth), decay[i], added);
    kernels.insert(kernels.end(), more.begin(), more.end());
  }
  return kernels;
}

/// Heat kernels of T(r).
template <typename T>
std::vector<HeatKernel<T>> transmittance_kernels(const std::vector<SlabSource<T>>& slabs, double decay) {
  const T straight = straight_through(slabs);
  double below = 0;  // what the light crosses under the sources
  for (const SlabSource<T>& slab : slabs) below += value_of(slab.below);
  const auto transform = [&](const Complex<T>& p, double = 0) {
    return stack_response(slabs, p).transmitted - Complex<T>(straight);
  };
  return heat_kernels<T>(transform, below, decay, value_of(transform(Complex<T>(T(0.0))).re));
}

}  // namespace opaline
