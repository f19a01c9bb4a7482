// What the tests of the fit share: small scenes, their pictures by a technique, and operators of them.
#pragma once

#include "datasets_synthetic/dataset.h"
#include "datasets_synthetic/shapes/shapes.h"
#include "fit/solve.h"
#include "fit/uncertainty.h"
#include "render/render_scene.h"
#include "tests/support/render_fixture.h"

#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace opaline::test {

inline const ProfileInfo& dipole() { return *find_profile("standard_dipole"); }

/// So few surface cells that a test takes a moment; the picture is made with the same ones.
inline OperatorSettings small_operator(std::size_t samples = 3000) {
  OperatorSettings settings;
  settings.samples = samples;
  settings.irradiance.area_samples = 16;
  return settings;
}

/// The scene's picture by a technique, with the operator's own cells.
inline Image picture_of(const Scene& scene, const OperatorSettings& op, const std::string& technique,
                        const std::map<std::string, std::string>& settings = {}) {
  RenderOptions options;
  options.technique = technique;
  options.settings = settings;
  options.shared = {op.samples, op.irradiance};
  return render_scene(scene, options).image;
}

/// A sphere of radius 10 mm, lit from the side.
inline Scene sphere_scene(const std::string& material, int pixels, int triangles = 2000) {
  return make_scene(make_sphere(10, triangles), library_material(material), 21, pixels);
}

/// The nodes that a fit with eta unknown uses.
inline EtaNodes free_eta() {
  const ParameterBounds bounds;
  return EtaNodes(bounds.eta_min, bounds.eta_max, 8);
}

/// RMS of a - b over the operator's pixels and R, G, B, relative to the RMS of b.
inline double relative_rms(const TransportOperator& op, const Image& a, const Image& b) {
  double error = 0, norm = 0;
  for (const std::uint32_t pixel : op.pixels)
    for (std::size_t c = 0; c < 3; ++c) {
      const auto x = static_cast<double>(a.data[pixel * a.channels.size() + c]),
                 y = static_cast<double>(b.data[pixel * b.channels.size() + c]);
      error += (x - y) * (x - y);
      norm += y * y;
    }
  return std::sqrt(error / norm);
}

/// Relative difference of a parameter in the user's units.
inline double relative_error(int i, const ParameterVector& found, const ParameterVector& truth) {
  const auto at = static_cast<std::size_t>(i);
  return natural_value(i, found[at]) / natural_value(i, truth[at]) - 1;
}

/// A material that is none of the library's: what a fit starts from.
inline Material neutral_material() {
  Material material;
  material.sigma_a = Rgb(0.05);
  material.sigma_s_prime = Rgb(1);
  material.eta = 1.35;
  return material;
}

}  // namespace opaline::test
