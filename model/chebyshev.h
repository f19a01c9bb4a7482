// Chebyshev series on [-1, 1]: made from values at the Chebyshev points, evaluated by Clenshaw's recurrence.
#pragma once

#include "model/conventions.h"

#include <cmath>
#include <cstddef>

namespace opaline {

/// Point j of n: the roots of T_n, from 1 downwards.
inline double chebyshev_point(std::size_t j, std::size_t n) {
  return std::cos(pi * (static_cast<double>(j) + 0.5) / static_cast<double>(n));
}

/// T_k at point j of n.
inline double chebyshev_at_point(std::size_t k, std::size_t j, std::size_t n) {
  return std::cos(pi * static_cast<double>(k) * (static_cast<double>(j) + 0.5) / static_cast<double>(n));
}

/// sum_k a[k] T_k(x). `a` is indexed by std::size_t and has a size() > 0; T is the wider of its scalar and x's.
template <typename Coefficients, typename T>
T clenshaw(const Coefficients& a, const T& x) {
  T b1(0.0), b2(0.0);
  for (std::size_t k = a.size() - 1; k > 0; --k) {
    const T b0 = 2.0 * x * b1 - b2 + a[k];
    b2 = b1;
    b1 = b0;
  }
  return x * b1 - b2 + a[0];
}

/// The coefficients of degree < n of f on [-1, 1] from its values at the n points, into a[0 ... n-1].
template <typename Coefficients, typename F>
void chebyshev_fit(std::size_t n, const F& f, Coefficients& a) {
  for (std::size_t k = 0; k < n; ++k) a[k] = 0;
  for (std::size_t j = 0; j < n; ++j) {
    const double value = f(chebyshev_point(j, n)) / static_cast<double>(n);
    for (std::size_t k = 0; k < n; ++k) a[k] += (k ? 2.0 : 1.0) * value * chebyshev_at_point(k, j, n);
  }
}

}  // namespace opaline
