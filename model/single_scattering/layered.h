// Exact single scattering in a stack of layers with smooth boundaries: what is reflected after one scattering, in any
// layer, of a plane wave from any direction (a BRDF), in total, and of a normal pencil beam by distance.
//
// Light goes down and up by refraction, attenuated on both ways, and scatters once; f = sum over layers j of
//
//   alpha_j p_j(cos) t_down t_up exp(-sum_{k<j} tau_k (1/mu_i,k + 1/mu_o,k)) (1 - exp(-tau_j (1/mu_i,j + 1/mu_o,j)))
//   ------------------------------------------------------------------------------------------------------------
//                                       eta_j^2 (mu_i,j + mu_o,j)
//
// with mu the cosines inside layer k by Snell's law, tau = sigma_t d, and t the product of the Fresnel transmittances
// of the boundaries on the way. Light that a boundary inside reflects is lost. What reaches the far side is lost.
// Reciprocal. With one infinite layer it is hanrahan_krueger_brdf, of which this is the layered form (Hanrahan &
// Krueger 1993).
//
// Units and normalisation: conventions.h; a layer's eta is its index over that of the space above the stack.
#pragma once

#include "model/single_scattering/half_space.h"

#include <vector>

namespace opaline {

template <typename T>
struct ScatteringLayer {
  ScatteringMedium<T> medium;
  T thickness{};  ///< [mm]; infinite in the last layer alone, if at all
};

namespace single_scattering_detail {

/// A direction on its way through the stack: cosine inside the current layer, transmitted share so far.
template <typename T>
struct Ray {
  T cos_outside, cos_inside, transmitted, index;

  explicit Ray(const T& cosine) : cos_outside(cosine), cos_inside(cosine), transmitted(1.0), index(1.0) {}

  /// Refracts into a layer of index `next`; false if it is totally reflected.
  bool enter(const T& next) {
    using std::sqrt;
    const T relative = next / index, sine_squared = (1.0 - cos_outside) * (1.0 + cos_outside) / (next * next);
    if (!(sine_squared < 1.0)) return false;
    transmitted *= fresnel_transmittance(cos_inside, relative);
    cos_inside = sqrt(1.0 - sine_squared);
    index = next;
    return true;
  }
};

}  // namespace single_scattering_detail

/// BRDF [1/sr] for directions outside: cosines cos_i, cos_o in (0, 1], and the cosine of the angle between the azimuths
/// in which the light travels before and after (1: straight on, -1: back to where it came from).
template <typename T>
T layered_single_scattering_brdf(const std::vector<ScatteringLayer<T>>& layers, const T& cos_i, const T& cos_o,
                                 const T& cos_azimuth) {
  using std::exp;
  using std::expm1;
  using std::sqrt;
  single_scattering_detail::Ray<T> in(cos_i), out(cos_o);
  const T sines = sqrt((1.0 - cos_i) * (1.0 + cos_i) * (1.0 - cos_o) * (1.0 + cos_o));
  T sum = T(0.0), seen = T(1.0);  // seen: attenuation down to the layer and back
  for (const ScatteringLayer<T>& layer : layers) {
    const ScatteringMedium<T>& m = layer.medium;
    if (!in.enter(m.eta) || !out.enter(m.eta)) break;
    const T eta_squared = m.eta * m.eta, sigma_t = m.sigma_a + m.sigma_s;
    const T way = sigma_t * layer.thickness * (1.0 / in.cos_inside + 1.0 / out.cos_inside);
    const T cos_phase = sines / eta_squared * cos_azimuth - in.cos_inside * out.cos_inside;
    sum -= m.sigma_s / sigma_t * phase_function(m, cos_phase) * in.transmitted * out.transmitted * seen * expm1(-way) /
           (eta_squared * (in.cos_inside + out.cos_inside));
    seen *= exp(-way);
  }
  return sum;
}

/// The whole reflected flux per unit of flux that ENTERS the first layer, for a plane wave from cos_i outside: the BRDF
/// over the hemisphere, 32 azimuths, double exponential in the cosine. Relative error 1e-10 for |g| <= 0.8, unless a
/// lower layer's index is below 1 and below the first one's: its critical angle is then a kink (1e-3).
template <typename T>
T layered_single_scattering_total(const std::vector<ScatteringLayer<T>>& layers, const T& cos_i) {
  using std::sqrt;
  constexpr int azimuths = 32;
  const T eta = layers.front().medium.eta, critical = eta < 1.0 ? T(sqrt((1.0 - eta) * (1.0 + eta))) : T(0.0);
  // cos_o = w/(1 + w): steps crowd at grazing and at normal exit.
  const auto integrand = [&](const T& w) {
    const T one_plus = 1.0 + w, cos_o = critical + (1.0 - critical) * w / one_plus;
    T ring = T(0.0);
    for (int i = 0; i < azimuths; ++i) {
      const double azimuth = 2 * pi * (i + 0.5) / azimuths;
      ring += layered_single_scattering_brdf(layers, cos_i, cos_o, T(std::cos(azimuth)));
    }
    return T(2.0 * pi / azimuths * (1.0 - critical) * ring * cos_o / (one_plus * one_plus));
  };
  return integrate_half_line<T>(integrand) / fresnel_transmittance(cos_i, layers.front().medium.eta);
}

/// R1(r) [1/mm^2] of a normal pencil beam per unit of flux that has entered, r > 0 [mm]; all layers have the index of
/// the first one (light then goes straight). With w of half_space.h the depth is r (w - 1/w)/2, and a layer between two
/// depths is the difference of two half spaces: absolute error 1e-10 of that half space.
template <typename T>
T layered_single_scattering_profile(const std::vector<ScatteringLayer<T>>& layers, const T& r) {
  using std::exp;
  using std::sqrt;
  const T w_c = single_scattering_detail::critical_cotangent(layers.front().medium.eta);
  T sum = T(0.0), top = T(0.0), tau = T(0.0);
  for (const ScatteringLayer<T>& layer : layers) {
    const ScatteringMedium<T>& m = layer.medium;
    const T sigma_t = m.sigma_a + m.sigma_s, excess = tau - sigma_t * top;
    // All of this medium's light from below `depth`; the way down and up crosses `excess` more than in it alone.
    const auto from_below = [&](const T& depth) {
      const T w_depth = (depth + sqrt(depth * depth + r * r)) / r, start = w_depth > w_c ? w_depth : w_c;
      const auto integrand = [&](const T& v) {
        const T w = start + v, both_ways = 2.0 * w * w / ((w - 1.0) * (w + 1.0));  // 1 + 1/mu
        const T way = sigma_t * r * w + (excess == 0.0 ? T(0.0) : T(excess * both_ways));
        return T(exp(-way) * single_scattering_detail::escaping(m, w));
      };
      return T(2.0 * m.sigma_s / r * integrate_half_line<T>(integrand));
    };
    sum += from_below(top);
    if (!(layer.thickness < 1e200)) break;
    top += layer.thickness;
    tau += sigma_t * layer.thickness;
    sum -= from_below(top);
  }
  return sum;
}

}  // namespace opaline
