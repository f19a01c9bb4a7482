// Layered media (Donner & Jensen 2005) in the Hankel domain: how a stack of slabs reflects and transmits a normal beam
// modulated with spatial frequency k.
//
// With sigma_tr replaced by beta(k) = sqrt(sigma_tr^2 + k^2) the closed totals of a slab (multipole.h) are the Hankel
// transforms of its R(r) and T(r); with b0, b1 the extrapolations, z the source's depth, L = d + b0 + b1
//
//   R~ = alpha' cosh(beta b0) sinh(beta (d + b1 - z))/sinh(beta L),  T~ = alpha' cosh(beta b1) sinh(beta (z +
//   b0))/sinh(beta L)
//
// and what convolutions do in r is products in k. For a stack 1 over a stack 2 (primes: lit from below)
//
//   M = 1/(1 - R1' R2),  R = R1 + T1 R2 T1' M,  T = T1 T2 M
//
// R~(0) is the total; R~(k) the reflectance of a pattern of spatial frequency k/(2 pi), as spatial frequency domain
// imaging measures it. The absorbed shares are carried along and 1 - R' is written as absorbed + transmitted, so that
// without absorption R + T = 1 to rounding, for any thickness.
//
// Limits of the model, not of the algebra: each layer is lit as if by a collimated normal beam, also from between
// layers, so a slab cut in two is not the slab; a layer thinner than its mean free path has no diffuse light (slab.h).
// A boundary's Fresnel reflection acts on the diffuse light scattered in the layers that touch it, by A of fresnel.h: a
// layer too thin to scatter does not pass it on.
//
// Templated on the scalar C of k^2 (real or Complex, for the inversion) over T; units: conventions.h.
#pragma once

#include "model/profiles/complex.h"
#include "model/profiles/parameters.h"
#include "model/profiles/slab.h"
#include "model/profiles/yukawa.h"

#include <vector>

namespace opaline {

/// Hankel transforms of a slab or stack; `below`: lit from below. absorbed = 1 - R - T at k = 0.
template <typename C>
struct Response {
  C reflected, transmitted, absorbed;
  C reflected_below, transmitted_below, absorbed_below;
};

namespace layered_detail {

/// 1 - exp(-x).
template <typename C>
C lost(const C& x) {
  using std::expm1;
  return -expm1(-x);
}

/// (1 - exp(-2 beta a))/(1 - exp(-2 beta b)); a/b at beta = 0.
template <typename C, typename T>
C ratio_of_sinh(const C& beta, const T& a, const T& b) {
  const C up = mean_decay(C(beta * T(2.0 * a))), down = mean_decay(C(beta * T(2.0 * b)));
  return up * T(a / b) / down;
}

/// cosh(beta a) sinh(beta b)/sinh(beta L), rest = L - a - b.
template <typename C, typename T>
C share(const C& beta, const T& a, const T& b, const T& rest, const T& period) {
  using std::exp;
  return exp(C(-beta * rest)) * T(0.5) * (C(T(1.0)) + exp(C(beta * T(-2.0 * a)))) * ratio_of_sinh(beta, b, period);
}

/// One of the two halves of 1 - R - T for a source that holds all the light: sinh(beta x)/sinh(beta L) (cosh(beta (d +
/// b))
/// - cosh(beta b)), b the far extrapolation and d the distance from the source to the far boundary.
template <typename C, typename T>
C loss(const C& beta, const T& x, const T& d, const T& b, const T& period) {
  return T(0.5) * ratio_of_sinh(beta, x, period) * lost(C(beta * T(d + 2.0 * b))) * lost(C(beta * d));
}

template <typename C, typename T>
C absorbed(const SlabSource<T>& s, const C& share_lost) {
  return C(T(s.strength * s.absorbed)) + share_lost * T(s.strength * s.alpha_prime);
}

}  // namespace layered_detail

/// A single slab or half space at k^2 (real part above what layered_profile.h calls the decay). Of a half space the
/// answers from below mean nothing, and nothing asks for them.
template <typename C, typename T>
Response<C> slab_response(const SlabSource<T>& s, const C& k_squared) {
  using namespace layered_detail;
  using std::exp;
  using std::sqrt;
  const C beta = sqrt(C(C(s.sigma_tr_squared) + k_squared)), none = C(T(0.0));
  if (s.infinite) {
    const T image = s.depth + 2.0 * s.z_b0;
    const C real_lost = lost(C(beta * s.depth)), image_lost = lost(C(beta * image));
    const C reflected = (exp(C(-beta * s.depth)) + exp(C(-beta * image))) * T(0.5 * s.alpha_prime);
    return {reflected, none, absorbed(s, C((real_lost + image_lost) * T(0.5))), none, none, none};
  }
  const T up = s.depth + s.z_b0, down = s.below + s.z_bd, light = s.strength * s.alpha_prime;
  const C straight = C(s.unscattered);
  // 1 - R - T for the source at depth z, and at depth d - z when lit from below.
  const auto lost_from = [&](const T& near, const T& far) {
    return absorbed(s, C(loss(beta, T(near + s.z_b0), far, s.z_bd, s.period) +
                         loss(beta, T(far + s.z_bd), near, s.z_b0, s.period)));
  };
  const T up_below = s.below + s.z_b0, down_below = s.depth + s.z_bd;
  return {share(beta, s.z_b0, down, s.depth, s.period) * light,
          straight + share(beta, s.z_bd, up, s.below, s.period) * light,
          lost_from(s.depth, s.below),
          share(beta, s.z_bd, up_below, s.depth, s.period) * light,
          straight + share(beta, s.z_b0, down_below, s.below, s.period) * light,
          lost_from(s.below, s.depth)};
}

/// What the light between `upper` and `lower` is to what `upper` sends down: 1/(1 - R1' R2), inverted, with
/// 1 - R1' R2 = (1 - R1') + R1' (1 - R2).
template <typename C>
C open_share(const Response<C>& upper, const Response<C>& lower) {
  return upper.absorbed_below + upper.transmitted_below + upper.reflected_below * (lower.absorbed + lower.transmitted);
}

/// What `lower` adds to the reflectance of `upper`.
template <typename C>
C added_reflectance(const Response<C>& upper, const Response<C>& lower) {
  return upper.transmitted / open_share(upper, lower) * lower.reflected * upper.transmitted_below;
}

/// `upper` on top of `lower`.
template <typename C>
Response<C> stacked(const Response<C>& upper, const Response<C>& lower) {
  const C open = open_share(upper, lower), down = upper.transmitted / open, up = lower.transmitted_below / open;
  return {upper.reflected + down * lower.reflected * upper.transmitted_below,
          down * lower.transmitted,
          upper.absorbed + down * (lower.absorbed + lower.reflected * upper.absorbed_below),
          lower.reflected_below + up * upper.reflected_below * lower.transmitted,
          up * upper.transmitted_below,
          lower.absorbed_below + up * (upper.absorbed_below + upper.reflected_below * lower.absorbed)};
}

/// A layer as in parameters.h, over a scalar.
template <typename T>
struct StackLayer {
  Medium<T> medium;
  T thickness{};
};

/// Slabs from the top down. eta of a layer's medium and index_below, the space under the stack: over the space above.
template <typename T>
std::vector<SlabSource<T>> stack_of(const std::vector<StackLayer<T>>& layers, const T& index_below) {
  std::vector<SlabSource<T>> slabs;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    Medium<T> m = layers[i].medium;
    const T index = m.eta, next = i + 1 < layers.size() ? layers[i + 1].medium.eta : index_below;
    if (i > 0) m.eta = index / layers[i - 1].medium.eta;
    slabs.emplace_back(Slab<T>{m, layers[i].thickness, T(index / next)});
  }
  return slabs;
}

/// Hankel transforms of the upper `count` slabs at k^2 [1/mm^2]; real k >= 0 for R~(k).
template <typename C, typename T>
Response<C> stack_response(const std::vector<SlabSource<T>>& slabs, const C& k_squared, std::size_t count) {
  Response<C> all = slab_response(slabs.front(), k_squared);
  for (std::size_t i = 1; i < count; ++i) all = stacked(all, slab_response(slabs[i], k_squared));
  return all;
}
template <typename C, typename T>
Response<C> stack_response(const std::vector<SlabSource<T>>& slabs, const C& k_squared) {
  return stack_response(slabs, k_squared, slabs.size());
}

}  // namespace opaline
