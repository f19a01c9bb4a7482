// What the tests of precomputed transfer share: tables of small scenes.
#pragma once

#include "datasets_synthetic/shapes/shapes.h"
#include "render/transfer/transfer_scene.h"
#include "tests/support/render_fixture.h"

#include <random>

namespace opaline::test {

inline glm::dvec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

/// The table of a scene's first object with what it is made of.
struct TableFixture {
  const Scene scene;
  const SharedScene shared;
  TransferSettings settings;
  TransferNodes nodes;
  TransferVertices vertices;
  Counters counters;
  TransferTable table;

  TableFixture(Scene s, TransferSettings given, std::size_t cells)
      : scene(std::move(s)),
        shared(scene, {cells, {}}, false),
        settings(std::move(given)),
        nodes(transfer_nodes(scene.objects[0].mesh, settings.directions, settings.distances)),
        vertices(scene.objects[0].mesh, settings.parts),
        table(make_object_table(shared, settings, 0, nodes, vertices, counters)) {}

  const Material& material() const { return scene.materials[0]; }
};

inline TransferSettings table_settings(int directions, bool any_light = true) {
  TransferSettings settings;
  settings.profile = "standard_dipole";
  settings.directions = directions;
  settings.any_light = any_light;
  return settings;
}

/// RMS of a - b over the RMS of b.
inline double relative_rms(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0, norm = 0;
  for (std::size_t i = 0; i < b.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]), norm += b[i] * b[i];
  return std::sqrt(squares / norm);
}

/// RMS error over all vertices, colours and table directions of what an encoded table gives for light from there,
/// over the RMS of the table.
inline double encoding_error(const TableFixture& f, const EncodedTransfer& transfer) {
  std::vector<double> given, wanted;
  Counters counters;
  for (std::size_t j = 0; j < f.nodes.per_level(); ++j) {
    const VertexExitance b = transfer.exitance({{f.nodes.directions[j], 0, Rgb(1)}}, f.nodes, counters);
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t v = 0; v < f.table.vertices; ++v) {
        given.push_back(static_cast<double>(b.channel[c][v]));
        wanted.push_back(static_cast<double>(f.table.row(j * static_cast<std::size_t>(f.table.tables) +
                                                         static_cast<std::size_t>(f.table.table_of[c]))[v]));
      }
  }
  return relative_rms(given, wanted);
}

}  // namespace opaline::test
