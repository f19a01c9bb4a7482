// The transfer table: what reaches each vertex under each light of a set, before any compression.
//
// q(v, node) = integral of R_d(|x_v - x|) F_t(eta, cos) cos V dA under the node's light: radiant exitance B for
// irradiance 1. (The paper's q is this over pi.) With vectors the table holds Q, three rows for each node, and
// q(v, w) = Q . w.
#pragma once

#include "render/irradiance/profile_gather.h"
#include "render/transfer/transfer_elements.h"

#include <functional>
#include <span>
#include <vector>

namespace opaline {

/// Values by row and vertex; a row for each key and distinct profile: row = key index * tables + table.
struct TransferTable {
  bool vectors = false;
  int tables = 1;               ///< distinct profiles
  int table_of[3] = {0, 0, 0};  ///< which serves each colour channel
  std::size_t vertices = 0;
  std::vector<std::uint32_t> keys;  ///< node, or 3 node + axis; ascending
  std::vector<float> values;

  static constexpr std::size_t lanes = 16;
  /// Floats from row to row: the vertices, rounded up with zeros.
  std::size_t stride() const { return (vertices + lanes - 1) / lanes * lanes; }
  std::size_t rows() const { return keys.size() * static_cast<std::size_t>(tables); }
  float* row(std::size_t r) { return values.data() + r * stride(); }
  const float* row(std::size_t r) const { return values.data() + r * stride(); }
};

/// What a table is of. All referred to must outlive the call.
struct TransferWork {
  const RayScene& rays;
  bool unshadowed;
  double eta;
  const TransferElements& elements;
  const ChannelProfiles& profiles;
  TransferColumns columns;
  std::span<const glm::vec3> positions;  ///< of the vertices
  std::span<const std::uint32_t> own;    ///< with discs: each vertex's element
  double max_relative_error;             ///< of the gather
};

/// Parts of a table that exist already, and where new ones go.
struct TransferStore {
  std::function<bool(std::size_t part, TransferTable& table)> restore;  ///< fills the part's rows if it has them
  std::function<void(std::size_t part, const TransferTable& table)> keep;
};

/// A table is made in parts of so many keys (the three of a vector stay together).
inline std::size_t keys_a_part(const TransferTable& table) {
  return table.vectors ? transfer_columns / 3 * 3 : transfer_columns;
}
std::size_t part_count(const TransferTable& table);

/// Rows of part `part`: first and one past the last.
std::pair<std::size_t, std::size_t> rows_of_part(const TransferTable& table, std::size_t part);

/// Makes the rows of `keys`, part by part, with progress from `from` to `to`. Memory: the table, and for every cell
/// about 1.2 kB.
TransferTable make_transfer_table(const TransferWork& work, std::vector<std::uint32_t> keys, const TransferStore& store,
                                  double from, double to, Counters& counters);

}  // namespace opaline
