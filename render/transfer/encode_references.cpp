#include "render/transfer/encode.h"
#include "render/transfer/reference_fit.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace opaline {
namespace {

/// The columns of some vertices.
TransferTable columns_of(const TransferTable& table, const std::vector<std::uint32_t>& vertices) {
  TransferTable out = {table.vectors,   table.tables, {table.table_of[0], table.table_of[1], table.table_of[2]},
                       vertices.size(), table.keys,   {}};
  out.values.assign(out.rows() * out.stride(), 0.0f);
  for (std::size_t r = 0; r < table.rows(); ++r)
    for (std::size_t i = 0; i < vertices.size(); ++i) out.row(r)[i] = table.row(r)[vertices[i]];
  return out;
}

ReferenceMesh choose_mesh(const TransferTable& table, const TransferNodes& nodes, const TransferVertices& vertices,
                          const ReferenceSettings& settings) {
  const bool by_transfer = settings.selection == ReferenceSelection::transfer,
             fitted = settings.weights == ReferenceWeights::least_squares;
  constexpr double by_shape = 0.6;  // of the points: fewer leave whole sides of a shape to a few, more are wasted
  ReferenceMesh mesh = make_reference_mesh(
      vertices,
      by_transfer ? static_cast<std::size_t>(by_shape * static_cast<double>(settings.points)) : settings.points);
  if (!by_transfer && !fitted) return mesh;
  const Remainder remainder(table, HarmonicFit(table, nodes, settings.order));
  if (by_transfer) add_points(remainder, settings.points, mesh);
  if (fitted) fit_weights(remainder, mesh);
  return mesh;
}

ReferencePoints make_points(const TransferTable& table, ReferenceMesh mesh, RowStorage storage) {
  ReferencePoints points;
  points.full = std::make_unique<EncodedTransfer>(encode_rows(columns_of(table, mesh.points), storage));
  points.points = std::move(mesh.points);
  points.triangles = std::move(mesh.triangles);
  points.triangle_of = std::move(mesh.triangle_of);
  points.triangle_of.resize(table.stride(), 0);
  const auto number = [](double w) {
    return static_cast<short>(std::lround(w * static_cast<double>(CornerBlend::weight_unit)));
  };
  for (const glm::dvec2& w : mesh.weights) points.weights.insert(points.weights.end(), {number(w.x), number(w.y)});
  points.weights.resize(2 * table.stride(), 0);
  return points;
}

/// Takes the blend of the (quantised) reference points from every row.
void subtract_blend(const ReferencePoints& points, TransferTable& table) {
  const CodedRows& full = points.full->rows;
  tbb::parallel_for(std::size_t{0}, table.rows(), [&](std::size_t r) {
    std::vector<float> value(full.stride(), 0.0f);
    const RowTerm term = full.term(r, 1);
    add_rows(full.storage(), {&term, 1}, 0, full.stride(), value.data());
    float* row = table.row(r);
    for (std::size_t v = 0; v < table.vertices; ++v) {
      const glm::uvec3 t = points.triangles[points.triangle_of[v]];
      const float a = static_cast<float>(points.weights[2 * v]) / CornerBlend::weight_unit,
                  b = static_cast<float>(points.weights[2 * v + 1]) / CornerBlend::weight_unit;
      row[v] -= a * value[t.x] + b * value[t.y] + (1 - a - b) * value[t.z];
    }
  });
}

/// What an encoded table's rows alone give under the light of a node, for one distinct profile.
std::vector<float> corrections(const EncodedTransfer& t, const TransferNodes& nodes, std::uint32_t node, int table) {
  const auto c = static_cast<std::size_t>(std::find(t.table_of, t.table_of + 3, table) - t.table_of);
  const RowWeights weights = t.weights({{nodes.direction(node), nodes.u(node), Rgb(1)}}, nodes);
  std::vector<RowTerm> terms;
  for (const RowWeight& w : weights[c]) terms.push_back(t.rows.term(w.row, w.weight));
  std::vector<float> values(t.rows.stride(), 0.0f);
  add_rows(t.rows.storage(), terms, 0, values.size(), values.data());
  return values;
}

/// The least bound of the corrections that costs nothing: with it the sum of squared errors over lights and vertices is
/// no more than without. (Where it is less than that, too, what is dark alone gains.)
float least_bound(const TransferTable& table, const TransferTable& difference, const EncodedTransfer& encoded,
                  const TransferNodes& nodes) {
  constexpr std::array<float, 7> bounds = {0.05f, 0.1f, 0.2f, 0.3f, 0.5f, 1, 1e6f};
  constexpr std::size_t every = 7;  // so many lights are enough
  const auto tables = static_cast<std::size_t>(table.tables);
  std::vector<std::array<double, bounds.size()>> errors((table.keys.size() + every - 1) / every * tables);
  tbb::parallel_for(std::size_t{0}, errors.size(), [&](std::size_t i) {
    const std::size_t key = i / tables * every, row = key * tables + i % tables;
    const std::vector<float> given = corrections(encoded, nodes, table.keys[key], static_cast<int>(i % tables));
    errors[i] = {};
    for (std::size_t v = 0; v < table.vertices; ++v) {
      const float wanted = difference.row(row)[v], blend = std::abs(table.row(row)[v] - wanted);
      for (std::size_t k = 0; k < bounds.size(); ++k) {
        const float most = bounds[k] * blend, error = std::clamp(given[v], -most, most) - wanted;
        errors[i][k] += static_cast<double>(error * error);
      }
    }
  });
  std::array<double, bounds.size()> sum{};
  for (const auto& e : errors)
    for (std::size_t k = 0; k < bounds.size(); ++k) sum[k] += e[k];
  std::size_t best = 0;
  while (sum[best] > sum.back()) ++best;
  return bounds[best];
}

}  // namespace

EncodedTransfer encode_references(const TransferTable& table, const TransferNodes& nodes,
                                  const TransferVertices& vertices, const ReferenceSettings& settings) {
  ReferencePoints points = make_points(table, choose_mesh(table, nodes, vertices, settings), settings.full);
  TransferTable difference = table;
  subtract_blend(points, difference);
  EncodedTransfer out = encode_harmonics(difference, nodes, settings.order, settings.difference);
  if (settings.weights == ReferenceWeights::least_squares)
    points.correction = least_bound(table, difference, out, nodes);
  out.references = std::move(points);
  return out;
}

}  // namespace opaline
