// The radial functions a profile is expanded in, so that a picture becomes linear in the profile.
//
//   R(r) ~ sum_n R(r_n) w(x_n)/w(x) L_n(t),   x = r^2 + r_0^2,  t = ln(x) / 2,  w(x) = x^(3/4)
//
// L_n is cubic Lagrange interpolation on nodes equally spaced in t, r_0 <= r_n <= r_max. The weight
// takes half of the r^-3 fall out of the interpolated function, so that its plateau near 0 and its
// tail are equally easy. `coefficient(n, R(r_n))` is what multiplies column n of the operator.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace opaline {

class RadialBasis {
 public:
  /// r_0: radius below which profiles are taken to be flat [mm]; spacing in t, e.g. 0.1.
  RadialBasis(double r_0, double r_max, double spacing)
      : x_0_(r_0 * r_0),
        t_0_(std::log(r_0)),
        count_(static_cast<int>(std::ceil(std::log(std::hypot(r_max, r_0) / r_0) / spacing)) + 2) {
    count_ = std::max(count_, 4);
    spacing_ = spacing;
  }
  int size() const { return count_; }
  double radius(int n) const { return std::sqrt(std::max(x(n) - x_0_, 0.0)); }
  double weight(int n) const { return std::pow(x(n), 0.75); }
  double x_0() const { return x_0_; }
  double t_0() const { return t_0_; }
  double spacing() const { return spacing_; }

 private:
  double x(int n) const { return std::exp(2 * (t_0_ + n * spacing_)); }
  double x_0_, t_0_, spacing_ = 0.1;
  int count_;
};

}  // namespace opaline
