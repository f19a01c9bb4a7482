// A transfer table as it is stored and used: a basis for the light, rows of coefficients, perhaps reference points.
//
//   B_c(v) = sum over rows of weight_c(row) * row(v)  +  blend of the reference points' own B
//
// where the sum is held to a share of the blend, if there is one. Lights come in only through the weights, of which
// there are as many for a hundred lights as for one.
//
//   basis      rows                                         weights
//   nodes      q at each node of light                      interpolation, transfer_lights.h
//   vectors    Q at each node, three rows                   interpolation times the light's direction
//   harmonics  coefficients of q, for each distance level   y_l^m of the light's direction
#pragma once

#include "render/counters.h"
#include "render/transfer/coded_rows.h"

#include <array>
#include <memory>
#include <optional>
#include <string>

namespace opaline {

enum class TransferBasis { nodes, vectors, harmonics };

/// Weights of the lights for the rows of a table, for each colour channel.
struct RowWeight {
  std::uint32_t row;
  float weight;
};
using RowWeights = std::array<std::vector<RowWeight>, 3>;

class EncodedTransfer;

/// Some of the vertices hold their transfer in full; every other one has the triangle of them that it lies in, and its
/// weights there (Hao, Varshney 2004, section 4.2).
struct ReferencePoints {
  std::unique_ptr<EncodedTransfer> full;   ///< of the reference points
  std::vector<std::uint32_t> points;       ///< which vertices they are
  std::vector<glm::uvec3> triangles;       ///< of reference points
  std::vector<std::uint32_t> triangle_of;  ///< of each vertex, padded as its rows are
  std::vector<short> weights;              ///< of its first and second corner, in units of 1 / CornerBlend::weight_unit

  /// The harmonics of the difference are held to this share of the blend: where little light comes they are more wrong
  /// than the blend. (Large: not held, as published.)
  float correction = 1e6f;

  double bytes_per_vertex() const;
};

/// Linear B of all vertices, a row for each channel, padded as the rows of the table.
struct VertexExitance {
  std::size_t stride = 0;
  std::array<std::unique_ptr<float[]>, 3> channel;
};

class EncodedTransfer {
 public:
  TransferBasis basis = TransferBasis::nodes;
  int order = 0;                    ///< of harmonics
  std::vector<std::uint32_t> keys;  ///< of the basis: node, 3 node + axis, or level * order^2 + coefficient
  int tables = 1;
  int table_of[3] = {0, 0, 0};
  CodedRows rows;
  std::optional<ReferencePoints> references;

  std::size_t vertices() const { return rows.vertices(); }
  double bytes_per_vertex() const;

  RowWeights weights(const std::vector<TransferLight>& lights, const TransferNodes& nodes) const;
  /// B of all vertices under the lights, not below 0. Counts rows done and skipped, in vertices.
  VertexExitance exitance(const std::vector<TransferLight>& lights, const TransferNodes& nodes,
                          Counters& counters) const;
  /// The same in the place of an earlier frame's: new memory would cost as much as a large table's rows.
  void exitance(const std::vector<TransferLight>& lights, const TransferNodes& nodes, VertexExitance& out,
                Counters& counters) const;

 private:
  std::vector<KeyWeight> key_weights(const std::vector<TransferLight>& lights, const TransferNodes& nodes) const;
};

/// The channel whose values, times a factor, are those of channel c: c itself, or an earlier one with the same profile
/// under light of the same colour.
struct EqualChannel {
  int channel;
  float factor;
};
EqualChannel equal_channel(const EncodedTransfer& transfer, const RowWeights& weights, int c);

}  // namespace opaline
