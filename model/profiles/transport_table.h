// Transport itself as a profile: a normal pencil beam on an isotropically scattering half space with a smooth boundary,
//   R(r) = sigma_t'^2 Rhat(rho; alpha', eta),  rho = sigma_t' r,
// all orders of scattering, per flux that has entered. By similarity it stands for g != 0 too, well beyond a few
// transport mean free paths only (model/transport for the rest).
//
//   Rhat = alpha' R_1(rho) + alpha'^2 P(rho; alpha') exp(Y(rho; alpha', eta))
//
// R_1, light scattered once, is the exact integral over the exit angle by a fixed rule: a sum of exp(-rho w)/rho.
// P = (1 + k d) exp(-k d)/(2 pi d^3), d^2 = rho^2 + 1, is a diffusion pole whose k = 1/v0(alpha') is transport's own
// exponent of decay (asymptotic_decay.h). Y, the slowly varying rest, is a Chebyshev series in three variables,
// transport_table.inc, made by `opaline transport table` from the deterministic solution of searchlight_mixture.h.
// Everything is smooth in rho, alpha' and eta.
//
// Domain: eta from 1 to 2, every alpha' from 0 to 1. An eta outside is held at the nearer end (the derivative by eta is
// 0 there). Beyond rho = 300/(1 + 9 sqrt(1 - alpha')) Y is held and P continues: the exponent stays exact.
//
// Error against the solver, measured at albedos and etas between the nodes: below 4e-4 from rho = 0.03 to 100 until
// what lies beyond is 1e-6 of the total (typically 5e-5), 3.5e-4 from 0.01; a tail further out is right in its
// exponent, and in its height until 0.7 of the radius above. Totals: within 2e-5 of h_function.h, 8e-5 at alpha' = 1,
// never above 1.
//
// The axis: R_1 grows like 1/rho. With rho~ = sqrt(rho^2 + c^2), c = 2.5e-4, the profile is R(rho~) plus a term
// proportional to exp(1 - rho~/c)/rho~ that holds the flux R_1 has inside c. So it is finite, smooth in r^2 and has the
// same integral; beyond a few c it is low by (c/rho)^2/2, 3e-4 at rho = 0.01 and 3e-6 at 0.1.
//
// Units and normalisation: conventions.h. sigma_t' in [1e-70, 1e70] 1/mm.
#pragma once

#include "model/chebyshev.h"
#include "model/fresnel.h"
#include "model/profiles/poles.h"
#include "model/transport/asymptotic_decay.h"

#include <array>
#include <cstdint>
#include <span>

namespace opaline {

/// The variables of the series Y, shared by its maker and its user. Each runs over [-1, 1].
struct TransportTableShape {
  static constexpr std::size_t radii = 64, albedos = 28, indices = 14;  ///< terms per variable
  static constexpr double unit = 1e-6;                                  ///< of the stored whole numbers
  static constexpr double core = 2.5e-4;                                ///< c [transport mean free paths]
  static constexpr double eta_min = 1, eta_max = 2;
  static constexpr double margin = 1e-5;  ///< Y is made this much too low: so no total exceeds 1

  // R isn't analytic in alpha' at 1 nor in eta at 1, but in the square roots of their distances; a little is added
  // under the roots to keep derivatives finite.
  static constexpr double albedo_shift = 1e-5, index_shift = 1e-4;

  /// sqrt(1 - alpha') for absorbed = 1 - alpha'.
  template <typename T>
  static T root(const T& absorbed) {
    using std::sqrt;
    return sqrt(absorbed + albedo_shift);
  }
  template <typename T>
  static T albedo_variable(const T& absorbed) {
    return along(root(absorbed), std::sqrt(albedo_shift), std::sqrt(1 + albedo_shift));
  }
  static double absorbed_at(double variable) {
    const double x = at(variable, std::sqrt(albedo_shift), std::sqrt(1 + albedo_shift));
    return x * x - albedo_shift;
  }

  template <typename T>
  static T index_variable(const T& eta) {
    using std::sqrt;
    return along(T(sqrt(eta - 1.0 + index_shift)), std::sqrt(index_shift), std::sqrt(1 + index_shift));
  }
  static double eta_at(double variable) {
    const double x = at(variable, std::sqrt(index_shift), std::sqrt(1 + index_shift));
    return 1 + x * x - index_shift;
  }

  /// The radius beyond which Y is held [transport mean free paths].
  template <typename T>
  static T reach(const T& absorbed) {
    return 300.0 / (1.0 + 9.0 * root(absorbed));
  }
  /// log rho, bent to stay below the reach's: rho/(1 + (rho/reach)^8)^(1/8).
  template <typename T>
  static T radius_variable(const T& rho, const T& reach) {
    using std::log;
    using std::log1p;
    const bool inside = rho < reach;
    const T ratio = inside ? T(rho / reach) : T(reach / rho), squared = ratio * ratio, fourth = squared * squared;
    const T bent = log(inside ? rho : reach) - 0.125 * log1p(fourth * fourth);
    return 2.0 * (bent - std::log(core)) / log(reach / core) - 1.0;
  }
  static double radius_at(double variable, double reach) { return core * std::pow(reach / core, 0.5 * (variable + 1)); }

 private:
  template <typename T>
  static T along(const T& x, double low, double high) {
    return (2.0 * x - (low + high)) / (high - low);
  }
  static double at(double variable, double low, double high) {
    return 0.5 * (low + high) + 0.5 * (high - low) * variable;
  }
};

/// Coefficients of Y in TransportTableShape::unit, [index][albedo][radius].
std::span<const std::int32_t> transport_table_coefficients();

/// Light scattered twice or more, alpha'^2 P exp(Y), for coefficients of Y made by transport_table_maker.h.
template <typename T>
struct TransportSeries {
  using Shape = TransportTableShape;
  T sigma_t_prime;                  ///< [1/mm]
  T albedo;                         ///< alpha'
  T eta;                            ///< held in the domain
  T decay_squared;                  ///< 1/v0^2
  T reach;                          ///< [transport mean free paths]
  std::array<T, Shape::radii> y{};  ///< Y's series in the radius

  TransportSeries(const Medium<T>& medium, std::span<const std::int32_t> coefficients)
      : sigma_t_prime(medium.sigma_a + medium.sigma_s_prime),
        albedo(medium.sigma_s_prime / sigma_t_prime),
        eta(held(medium.eta)) {
    const T absorbed = medium.sigma_a / sigma_t_prime;
    decay_squared = asymptotic_decay_squared(absorbed);
    reach = Shape::reach(absorbed);
    const auto albedo_terms = polynomials<Shape::albedos>(Shape::albedo_variable(absorbed));
    const auto index_terms = polynomials<Shape::indices>(Shape::index_variable(eta));
    const std::int32_t* row = coefficients.data();
    for (const T& of_index : index_terms) {
      for (const T& of_albedo : albedo_terms) {
        const T weight = Shape::unit * of_index * of_albedo;
        for (std::size_t k = 0; k < Shape::radii; ++k) {
          if (row[k] != 0) y[k] += static_cast<double>(row[k]) * weight;
        }
        row += Shape::radii;
      }
    }
  }

  /// rho^2 + c^2 for r [mm]; bounded.
  T softened_squared(const T& r, double c = Shape::core) const {
    constexpr double farthest = 1e130;
    const T scaled = r * sigma_t_prime, bounded = scaled < farthest ? scaled : T(farthest);
    return bounded * bounded + c * c;
  }

  /// At the softened rho and its square.
  T evaluate(const T& rho, const T& squared) const {
    using std::exp;
    const T pole = pole_evaluate_squared(squared, T(1.0), decay_squared);
    return albedo * albedo * pole * exp(clenshaw(y, Shape::radius_variable(rho, reach)));
  }

  /// A flux at the axis, spread over a core of radius c; rho: softened by c.
  static T core(const T& flux, const T& rho, double c) {
    using std::exp;
    return flux / (2.0 * pi * c) * exp(1.0 - rho / c) / rho;
  }

 private:
  static T held(const T& eta) {
    return eta < Shape::eta_min ? T(Shape::eta_min) : eta > Shape::eta_max ? T(Shape::eta_max) : eta;
  }

  /// T_0 ... T_(n-1) at x.
  template <std::size_t n>
  static std::array<T, n> polynomials(const T& x) {
    std::array<T, n> p;
    p[0] = T(1.0);
    p[1] = x;
    for (std::size_t k = 2; k < n; ++k) p[k] = 2.0 * x * p[k - 1] - p[k - 2];
    return p;
  }
};

/// R_1 for albedo 1 as sum_i strength_i exp(-rho rate_i)/rho over the exit angle outside, by the tanh-sinh rule. Error
/// below 1e-8 of the total, 3e-5 of R_1 up to rho = 10.
template <typename T>
struct OnceScattered {
  static constexpr int half = 14, count = 2 * half + 1;
  std::array<T, count> strength, rate;

  explicit OnceScattered(const T& eta) {
    using std::sqrt;
    constexpr double step = 0.16;
    // A hair above 1: at 1 itself the reflectance forgets its derivative at grazing angles.
    const T n = eta + 1e-9;
    for (int i = -half; i <= half; ++i) {
      const double y = i * step, e = std::exp(-pi * std::sinh(std::abs(y))), angle = 0.5 * pi * e / (1 + e);
      const double weight = 0.5 * pi * step * pi * std::cosh(y) * e / ((1 + e) * (1 + e));
      const double cosine = i < 0 ? std::cos(angle) : std::sin(angle);
      const T sine = (i < 0 ? std::sin(angle) : std::cos(angle)) / n;  // inside
      const auto k = static_cast<std::size_t>(i + half);
      strength[k] = weight * cosine / (4.0 * pi) * fresnel_transmittance(T(cosine), n) / n;
      rate[k] = (1.0 + sqrt((1.0 - sine) * (1.0 + sine))) / sine;
    }
  }

  T evaluate(const T& rho) const {
    using std::exp;
    T sum(0.0);
    for (std::size_t k = 0; k < count; ++k) sum += strength[k] * exp(-rho * rate[k]);
    return sum / rho;
  }

  /// 2 pi int_0^rho R_1 s ds.
  T cumulative(const T& rho) const {
    using std::expm1;
    T sum(0.0);
    for (std::size_t k = 0; k < count; ++k) sum -= strength[k] * expm1(-rho * rate[k]) / rate[k];
    return 2.0 * pi * sum;
  }
};

template <typename T>
struct TransportTable {
  TransportSeries<T> multiple;
  OnceScattered<T> once;  ///< R_1
  T core_flux;            ///< of R_1, inside the core

  explicit TransportTable(const Medium<T>& medium)
      : multiple(medium, transport_table_coefficients()),
        once(multiple.eta),
        core_flux(multiple.albedo * once.cumulative(T(TransportTableShape::core))) {}

  /// R [1/mm^2] at distance r [mm].
  T evaluate(const T& r) const {
    using std::sqrt;
    const T q = multiple.softened_squared(r), rho = sqrt(q);
    const T all = multiple.albedo * once.evaluate(rho) + multiple.evaluate(rho, q) +
                  multiple.core(core_flux, rho, TransportTableShape::core);
    return multiple.sigma_t_prime * multiple.sigma_t_prime * all;
  }

  T core_radius() const { return TransportTableShape::core / multiple.sigma_t_prime; }
};

}  // namespace opaline
