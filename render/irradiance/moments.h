// Central moments of a flux distribution up to the fourth order.
//
// The moment of order n is kept as the homogeneous polynomial M_n(x) = E (x . delta)^n in a direction x: its
// coefficients hold the multiplicities (2 xy, 6 xyz, ...), and shifting or merging distributions is multiplying
// polynomials. Monomial x^(n-m) y^(m-c) z^c stands at m (m + 1) / 2 + c, whatever n is: xx xy xz yy yz zz, ...
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cmath>

namespace opaline {

template <int N>
using Form = std::array<float, static_cast<std::size_t>((N + 1) * (N + 2) / 2)>;

constexpr std::size_t monomial(int m, int c) { return static_cast<std::size_t>(m * (m + 1) / 2 + c); }

/// (a . x) p(x).
template <std::size_t Size>
constexpr auto times_linear(const glm::vec3& a, const std::array<float, Size>& p) {
  constexpr int degree = Size == 1 ? 0 : Size == 3 ? 1 : Size == 6 ? 2 : 3;
  static_assert(monomial(degree, degree) + 1 == Size);
  Form<degree + 1> product{};
  for (int m = 0; m <= degree; ++m)
    for (int c = 0; c <= m; ++c) {
      const float value = p[monomial(m, c)];
      product[monomial(m, c)] += a.x * value;
      product[monomial(m + 1, c)] += a.y * value;
      product[monomial(m + 1, c + 1)] += a.z * value;
    }
  return product;
}

/// The Laplacian; that of E (x . delta)^n is n (n - 1) E (x . delta)^(n - 2) |delta|^2.
template <int N>
Form<N - 2> laplacian(const Form<N>& p) {
  Form<N - 2> sum{};
  for (int m = 0; m <= N; ++m)
    for (int c = 0; c <= m; ++c) {
      const int a = N - m, b = m - c;
      const float value = p[monomial(m, c)];
      if (a >= 2) sum[monomial(m, c)] += static_cast<float>(a * (a - 1)) * value;
      if (b >= 2) sum[monomial(m - 2, c)] += static_cast<float>(b * (b - 1)) * value;
      if (c >= 2) sum[monomial(m - 2, c - 2)] += static_cast<float>(c * (c - 1)) * value;
    }
  return sum;
}

/// Frobenius norm of the symmetric tensor: |M_n(u)| is at most this for every unit u.
template <int N>
float frobenius_norm(const Form<N>& p) {
  constexpr float factorial[] = {1, 1, 2, 6, 24};
  float sum = 0;
  for (int m = 0; m <= N; ++m)
    for (int c = 0; c <= m; ++c) {
      const float multiplicity = factorial[N] / (factorial[N - m] * factorial[m - c] * factorial[c]);
      sum += p[monomial(m, c)] * p[monomial(m, c)] / multiplicity;
    }
  return std::sqrt(sum);
}

/// Of a distribution of unit flux about its centroid. Order n in mm^n.
struct Moments {
  Form<2> second{};
  Form<3> third{};
  Form<4> fourth{};

  float trace() const { return second[0] + second[3] + second[5]; }
};

/// Uniform flux on a triangle, by its corners relative to the centroid: sums of powers over 12, 30 and 30
/// (Dirichlet moments, with the first power sum 0).
inline Moments triangle_moments(const std::array<glm::vec3, 3>& corners) {
  Moments moments;
  for (const glm::vec3& d : corners) {
    const Form<2> square = times_linear(d, Form<1>{d.x, d.y, d.z});
    const Form<3> cube = times_linear(d, square);
    const Form<4> fourth = times_linear(d, cube);
    for (std::size_t k = 0; k < square.size(); ++k) moments.second[k] += square[k] / 12;
    for (std::size_t k = 0; k < cube.size(); ++k) moments.third[k] += cube[k] / 30;
    for (std::size_t k = 0; k < fourth.size(); ++k) moments.fourth[k] += fourth[k] / 30;
  }
  return moments;
}

/// Two distributions with shares p + q = 1 of the flux, the second's centroid `apart` from the first's.
inline Moments merged(const Moments& a, float p, const Moments& b, float q, const glm::vec3& apart) {
  Form<2> difference{}, weighted{};
  Form<3> third_difference{};
  for (std::size_t k = 0; k < difference.size(); ++k) {
    difference[k] = 3 * (b.second[k] - a.second[k]);
    weighted[k] = 6 * (q * a.second[k] + p * b.second[k]);
  }
  for (std::size_t k = 0; k < third_difference.size(); ++k) third_difference[k] = 4 * (b.third[k] - a.third[k]);
  const Form<1> linear{apart.x, apart.y, apart.z};
  const Form<2> square = times_linear(apart, linear);
  // Both distributions move along `apart`, by -q and p of it.
  for (std::size_t k = 0; k < square.size(); ++k) {
    difference[k] += (p - q) * square[k];
    weighted[k] += (p * p * p + q * q * q) * square[k];
  }
  const Form<3> cube = times_linear(apart, difference), pull = times_linear(apart, weighted);
  for (std::size_t k = 0; k < third_difference.size(); ++k) third_difference[k] += pull[k];
  const Form<4> fourth = times_linear(apart, third_difference);
  Moments sum;
  const float pq = p * q;
  for (std::size_t k = 0; k < square.size(); ++k) sum.second[k] = p * a.second[k] + q * b.second[k] + pq * square[k];
  for (std::size_t k = 0; k < cube.size(); ++k) sum.third[k] = p * a.third[k] + q * b.third[k] + pq * cube[k];
  for (std::size_t k = 0; k < fourth.size(); ++k) sum.fourth[k] = p * a.fourth[k] + q * b.fourth[k] + pq * fourth[k];
  return sum;
}

}  // namespace opaline
