// The image as a linear function of the profile. Each pixel's irradiance is gathered by distance
// once, through the cluster tree; afterwards any profile's picture is a matrix product:
//
//   L_c(pixel) = colour_c / (pi c(eta)) sum_k l_k(eta) sum_n w_n R_c(r_n) M(pixel, k, n)
//
// with radial nodes n (radial_basis.h) and eta nodes k (eta_nodes.h). M holds the entering F_t (in
// the gathered flux) and the leaving F_t of the pixel, both at eta_k.
#pragma once

#include "fit/eta_nodes.h"
#include "fit/radial_basis.h"
#include "model/profiles/profile.h"
#include "render/techniques/shared_scene.h"

#include <vector>

namespace opaline {

struct OperatorSettings {
  std::size_t samples = 100000;  ///< surface cells over all objects
  IrradianceSettings irradiance;
  double core_fraction = 2.5e-4;  ///< r_0 as a fraction of the fitted objects' largest diameter
  double spacing = 0.1;           ///< of the radial nodes in ln r
  double opening = 0.2;           ///< largest cluster radius / distance
};

struct TransportOperator {
  RadialBasis radial;
  EtaNodes etas;
  int light_channels = 1;  ///< 1: one field, times `colour`; 3: one per RGB channel
  Rgb colour{1};
  ExitLobe lobe = ExitLobe::normalised;
  int width = 0, height = 0;            ///< of the film
  std::vector<std::uint32_t> pixels{};  ///< pixel of each row
  /// rows x light_channels x (etas * radial): row-major; element (k * radial.size() + n) of a row.
  std::vector<float> values{};
  Counters counters{};
  double seconds = 0;

  std::size_t rows() const { return pixels.size(); }
  std::size_t columns() const {
    return static_cast<std::size_t>(etas.size()) * static_cast<std::size_t>(radial.size());
  }
  const float* row(std::size_t pixel, int channel) const {
    return &values[(pixel * static_cast<std::size_t>(light_channels) + static_cast<std::size_t>(channel)) * columns()];
  }
  /// Which of the light channels colour channel c uses.
  int light_channel(int c) const { return light_channels == 1 ? 0 : c; }
  /// What its values are to be multiplied by.
  double light_colour(int c) const { return light_channels == 1 ? colour[c] : 1; }
};

/// Gathers the operator for all pixels that see an object of `material` and pass the mask (one value
/// per film pixel, > 0 passes; empty: all pass).
TransportOperator build_operator(const Scene& scene, int material, const EtaNodes& etas,
                                 const OperatorSettings& settings, const std::vector<float>& mask = {});

/// The rows of the operator whose pixels pass the mask (one value per film pixel, > 0 passes).
TransportOperator some_rows(const TransportOperator& op, const std::vector<float>& mask);

/// What multiplies the operator's eta nodes: l_k(eta) / (pi c(eta)), and its derivative.
struct EtaFactors {
  std::vector<double> value, d_eta;
};
EtaFactors eta_factors(const TransportOperator& op, double eta);

/// What multiplies its radial nodes: w_n R(r_n), and its derivatives.
std::vector<ProfileGradient> radial_coefficients(const TransportOperator& op, const ProfileInfo& profile,
                                                 const Medium<double>& medium);

/// The product of both and the light's colour: coefficients of the operator's columns for colour channel c of a medium,
/// and their derivatives with respect to sigma_a, sigma_s', eta. Each has columns() entries.
struct ColumnCoefficients {
  std::vector<double> value, d_sigma_a, d_sigma_s_prime, d_eta;
};
ColumnCoefficients column_coefficients(const TransportOperator& op, const ProfileInfo& profile,
                                       const Medium<double>& medium, int channel);

/// The operator's picture of a material: RGBA, zero where no row is.
Image operator_image(const TransportOperator& op, const ProfileInfo& profile, const Material& material);

}  // namespace opaline
