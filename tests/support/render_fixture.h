// What the tests of the renderer share: scenes made in memory, and the difference of two pictures.
#pragma once

#include "model/materials/library.h"
#include "render/irradiance/profile_gather.h"
#include "render/techniques/technique.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace opaline::test {

/// A measured material of the library by name.
inline Material library_material(const std::string& name) {
  const MaterialRow* row = find_material(name);
  if (!row) throw std::runtime_error("no material " + name);
  Material material;
  material.name = name;
  material.eta = row->eta;
  for (std::size_t c = 0; c < 3; ++c) {
    material.sigma_a[static_cast<int>(c)] = row->sigma_a[c];
    material.sigma_s_prime[static_cast<int>(c)] = row->sigma_s_prime[c];
  }
  return material;
}

/// One object of one material, lit from the upper left, seen from the front by an orthographic camera of
/// `pixels` x `pixels` that covers `height` mm.
inline Scene make_scene(Mesh mesh, Material material, double height, int pixels = 24) {
  Scene scene;
  scene.film = {pixels, pixels};
  scene.camera.type = Camera::Type::orthographic;
  scene.camera.position = {0, 0, 10 * height};
  scene.camera.height = height;
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(0.8, -0.3, -0.5)), Rgb(1), 0}};
  scene.materials = {std::move(material)};
  scene.objects.push_back({"object", std::move(mesh), 0});
  return scene;
}

/// An irradiance field with one value for every cell.
inline IrradianceField constant_irradiance(std::size_t cells, float value) {
  return {1, 1, Rgb(1), std::vector<float>(cells, value)};
}

/// (a - b) / b in one channel, over the points where b is above `floor`.
struct Difference {
  std::size_t count = 0;
  double rms = 0, mean = 0, worst = 0;
};
inline Difference relative_difference(std::span<const glm::vec3> a, std::span<const glm::vec3> b, int channel,
                                      float floor) {
  Difference d;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (b[i][channel] <= floor) continue;
    const double e = static_cast<double>(a[i][channel]) / static_cast<double>(b[i][channel]) - 1;
    ++d.count;
    d.mean += e;
    d.rms += e * e;
    d.worst = std::max(d.worst, std::abs(e));
  }
  const double n = static_cast<double>(std::max<std::size_t>(d.count, 1));
  d.mean /= n;
  d.rms = std::sqrt(d.rms / n);
  return d;
}

/// Mean of the largest channel of E over the lit cells.
inline float mean_lit_irradiance(const SurfaceCells& cells, const IrradianceField& field) {
  double flux = 0, area = 0;
  const auto width = static_cast<std::size_t>(field.width());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const float e = *std::max_element(field.values.begin() + static_cast<std::ptrdiff_t>(i * width),
                                      field.values.begin() + static_cast<std::ptrdiff_t>((i + 1) * width));
    if (e <= 0) continue;
    flux += static_cast<double>(e * cell_area(cells[i]));
    area += static_cast<double>(cell_area(cells[i]));
  }
  return static_cast<float>(flux / area);
}

/// What one object needs for a gather, and the gather.
struct GatherFixture {
  SurfaceCells cells;
  IrradianceField field;
  ClusterTree tree;
  ChannelProfiles profiles;

  GatherFixture(SurfaceCells surface, IrradianceField irradiance, const Material& material, double r_max)
      : cells(std::move(surface)),
        field(std::move(irradiance)),
        tree(build_cluster_tree(cells, field)),
        profiles(*find_profile("standard_dipole"), material, r_max) {}

  std::vector<glm::vec3> gather(std::span<const glm::vec3> points, const GatherSettings& settings,
                                Counters* counters = nullptr) const {
    Counters ignored;
    return gather_exitance(tree, cells, profiles, field.colour, points, settings, counters ? *counters : ignored);
  }
};

inline GatherSettings brute_force(double cell_error = 1e-5) { return {GatherSettings::Criterion::none, cell_error, 0}; }
inline GatherSettings by_error(double tolerance) { return {GatherSettings::Criterion::error, tolerance, 0}; }
inline GatherSettings by_bound(double tolerance) { return {GatherSettings::Criterion::bound, tolerance, 0}; }
inline GatherSettings by_solid_angle(double quality) { return {GatherSettings::Criterion::solid_angle, 0, quality}; }

}  // namespace opaline::test
