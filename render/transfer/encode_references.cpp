#include "render/transfer/encode.h"
#include "render/transfer/harmonic_fit.h"
#include "render/transfer/reference_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
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

/// Least squares, two unknowns: weights of the first two of three columns, the third having the rest of 1.
glm::dvec2 best_weights(const float* own, const float* const corners[3], std::size_t rows, const glm::dvec2& before) {
  double aa = 0, ab = 0, bb = 0, ay = 0, by = 0;
  for (std::size_t r = 0; r < rows; ++r) {
    const auto third = static_cast<double>(corners[2][r]);
    const double a = static_cast<double>(corners[0][r]) - third, b = static_cast<double>(corners[1][r]) - third,
                 y = static_cast<double>(own[r]) - third;
    aa += a * a, ab += a * b, bb += b * b, ay += a * y, by += b * y;
  }
  // A little pull towards what place says, where corners are alike.
  const double pull = 1e-4 * (aa + bb) + 1e-30;
  aa += pull, bb += pull, ay += pull * before.x, by += pull * before.y;
  const double determinant = aa * bb - ab * ab;
  if (!(determinant > 0)) return before;
  const glm::dvec2 w((ay * bb - by * ab) / determinant, (by * aa - ay * ab) / determinant);
  return glm::clamp(w, glm::dvec2(-1), glm::dvec2(2));
}

/// Weights that leave least of what the harmonics cannot hold.
void improve_weights(const TransferTable& table, const HarmonicFit& fit, ReferenceMesh& mesh) {
  TransferTable rest = table;
  fit.subtract(fit.coefficients(table), rest);
  const std::size_t rows = rest.rows(), points = mesh.points.size();
  std::vector<float> of_points(points * rows);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t i = 0; i < points; ++i) of_points[i * rows + r] = rest.row(r)[mesh.points[i]];
  constexpr std::size_t block = TransferTable::lanes;  // a line of the cache of every row
  tbb::parallel_for(std::size_t{0}, rest.stride() / block, [&](std::size_t b) {
    std::vector<float> own(block * rows);
    for (std::size_t r = 0; r < rows; ++r)
      for (std::size_t i = 0; i < block; ++i) own[i * rows + r] = rest.row(r)[b * block + i];
    for (std::size_t v = b * block; v < std::min((b + 1) * block, rest.vertices); ++v) {
      const glm::uvec3 t = mesh.triangles[mesh.triangle_of[v]];
      const float* corners[3] = {&of_points[t.x * rows], &of_points[t.y * rows], &of_points[t.z * rows]};
      mesh.weights[v] = best_weights(&own[(v % block) * rows], corners, rows, mesh.weights[v]);
    }
  });
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

}  // namespace

EncodedTransfer encode_references(const TransferTable& table, const TransferNodes& nodes,
                                  const TransferVertices& vertices, const ReferenceSettings& settings) {
  ReferenceMesh mesh = make_reference_mesh(vertices, settings.points);
  if (settings.weights == ReferenceWeights::least_squares)
    improve_weights(table, HarmonicFit(table, nodes, settings.order), mesh);
  ReferencePoints points = make_points(table, std::move(mesh), settings.full);
  TransferTable difference = table;
  subtract_blend(points, difference);
  EncodedTransfer out = encode_harmonics(difference, nodes, settings.order, settings.difference);
  out.references = std::move(points);
  return out;
}

}  // namespace opaline
