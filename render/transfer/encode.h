// From a transfer table to what is kept of it. Each form's size and error: render/techniques/precomputed_transfer.md.
#pragma once

#include "render/transfer/encoded_transfer.h"
#include "render/transfer/transfer_vertices.h"

namespace opaline {

/// The rows themselves, as floats or as codes of one Lloyd quantiser for each distinct profile.
EncodedTransfer encode_rows(TransferTable table, RowStorage storage);

/// Spherical harmonics with l < order of every distance level: least squares over the table's directions, of which all
/// must be there. Throws InputError("--set directions") if they are too few to determine the coefficients.
EncodedTransfer encode_harmonics(const TransferTable& table, const TransferNodes& nodes, int order,
                                 RowStorage storage = RowStorage::i16);

enum class ReferenceSelection {
  shape,    ///< simplification of the mesh (the paper)
  transfer  ///< three in five so, the others where most is left that the harmonics cannot hold
};

enum class ReferenceWeights {
  barycentric,   ///< of the nearest point of the triangle (the paper)
  least_squares  ///< what leaves least to the harmonics, which are then held to a share of the blend (reference_fit.h)
};

struct ReferenceSettings {
  std::size_t points = 1000;  ///< wished for; what comes out may be more where the mesh can't be simplified so far
  ReferenceSelection selection = ReferenceSelection::shape;
  ReferenceWeights weights = ReferenceWeights::barycentric;
  int order = 3;
  RowStorage full = RowStorage::code8;     ///< of the reference points
  RowStorage difference = RowStorage::i8;  ///< of the harmonics
};

/// Reference points, and harmonics of the difference. The harmonics see the quantised reference points and weights, so
/// they make good what these lose.
EncodedTransfer encode_references(const TransferTable& table, const TransferNodes& nodes,
                                  const TransferVertices& vertices, const ReferenceSettings& settings);

}  // namespace opaline
