// Refraction indices at which the Fresnel factors are sampled. Between them the product of the
// entering and the leaving F_t is interpolated (Chebyshev nodes in ln(eta - 1)),
// which keeps the operator linear. With 8 nodes over 1.05 .. 2 the product is right to 5e-6.
#pragma once

#include "model/conventions.h"

#include <cmath>
#include <vector>

namespace opaline {

class EtaNodes {
 public:
  /// One node: eta is known.
  explicit EtaNodes(double eta) : etas_{eta} {}

  /// `count` nodes over [lo, hi], 1 < lo < hi.
  EtaNodes(double lo, double hi, int count) {
    const double a = std::log(lo - 1), b = std::log(hi - 1);
    for (int k = 0; k < count; ++k) {
      const double angle = (2 * k + 1) * pi / (2 * count);
      positions_.push_back((a + b) / 2 + (b - a) / 2 * std::cos(angle));
      etas_.push_back(1 + std::exp(positions_.back()));
    }
  }

  const std::vector<double>& etas() const { return etas_; }
  int size() const { return static_cast<int>(etas_.size()); }

  /// Lagrange basis at eta: values that sum to 1.
  template <typename T>
  std::vector<T> basis(const T& eta) const {
    using std::log;
    if (etas_.size() == 1) return {T(1.0)};
    const T u = log(eta - 1.0);
    std::vector<T> value;
    for (std::size_t k = 0; k < etas_.size(); ++k) {
      T term(1.0);
      for (std::size_t j = 0; j < etas_.size(); ++j)
        if (j != k) term = term * ((u - positions_[j]) / (positions_[k] - positions_[j]));
      value.push_back(term);
    }
    return value;
  }

 private:
  std::vector<double> etas_, positions_;
};

}  // namespace opaline
