// The multipole of a slab (Donner & Jensen 2005): a normal beam's source and its images in the two extrapolated
// boundaries; diffuse reflectance R(r) and transmittance T(r).
//
//   R(r) = (alpha'/2) sum_i [ P(r; z_r,i) - P(r; z_v,i) ],  T(r) = (alpha'/2) sum_i [ P(r; d - z_r,i) - P(r; d - z_v,i)
//   ] z_r,i = 2 i L + l,  z_v,i = 2 i L - l - 2 z_b0
//
// with the source of slab.h and P of poles.h. In terms of Q of pole_lattice.h that is
// R = (alpha'/2) (Q(l) + Q(l + 2 z_b0)), and T the same with the slab turned round. The boundary is the standard
// dipole's, which R becomes for d -> infinity.
//
// Relative error 1e-10 for r up to 200 L. Closed totals: derived here. Where one extrapolated boundary lies further out
// than the other by more than d, the sums turn negative far from the beam: the model does not hold there.
// Units and normalisation: conventions.h. s = 0 is no exception; dual numbers as in standard_dipole.h.
#pragma once

#include "model/profiles/pole_lattice.h"
#include "model/profiles/slab.h"

namespace opaline {

template <typename T>
struct Multipole {
  SlabSource<T> slab;
  PoleLattice<T> lattice;

  /// A slab of finite thickness.
  explicit Multipole(const Slab<T>& of) : slab(of), lattice{slab.period, slab.sigma_tr_squared} {}

  /// R [1/mm^2] at distance r [mm] from the beam on its side, T on the other.
  T reflectance(const T& r) const { return seen(r, slab.depth, slab.below, slab.z_b0, slab.z_bd); }
  T transmittance(const T& r) const { return seen(r, slab.below, slab.depth, slab.z_bd, slab.z_b0); }

  /// 2 pi int_0^inf R r dr = alpha' cosh(s z_b0) sinh(s (d + z_bd - l))/sinh(s L), and that of T.
  T total_reflectance() const { return total(slab.z_b0, T(slab.below + slab.z_bd), slab.depth); }
  T total_transmittance() const { return total(slab.z_bd, T(slab.depth + slab.z_b0), slab.below); }

 private:
  /// Through the boundary `near` the source, with extrapolation z_near there.
  T seen(const T& r, const T& near, const T& far, const T& z_near, const T& z_far) const {
    const T real = lattice.evaluate(r, near, T(far + z_near + z_far));
    const T image = lattice.evaluate(r, T(near + 2.0 * z_near), T(far + (z_far - z_near)));
    return 0.5 * slab.strength * slab.alpha_prime * (real + image);
  }

  /// cosh(s a) sinh(s b)/sinh(s L) with L = a + b + rest: no overflow, b/L at s = 0.
  T total(const T& a, const T& b, const T& rest) const {
    using std::exp;
    using std::sqrt;
    const T s = slab.sigma_tr_squared == 0.0 ? T(0.0) : T(sqrt(slab.sigma_tr_squared));
    const T mean = b * mean_decay(T(2.0 * s * b)) / (slab.period * mean_decay(T(2.0 * s * slab.period)));
    return slab.strength * slab.alpha_prime * exp(-s * rest) * 0.5 * (1.0 + exp(-2.0 * s * a)) * mean;
  }
};

}  // namespace opaline
