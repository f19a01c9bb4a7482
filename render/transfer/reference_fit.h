// Reference points and weights chosen by what they are for: that little is left which the harmonics cannot hold. Hao
// and Varshney name both as future work (2004, section 6).
#pragma once

#include "render/transfer/harmonic_fit.h"
#include "render/transfer/reference_mesh.h"

namespace opaline {

/// What the harmonics cannot hold of each vertex's values, side by side.
class Remainder {
 public:
  static constexpr std::size_t lanes = 16;

  Remainder(const TransferTable& table, const HarmonicFit& fit);

  /// Values a vertex, padded with zeros to a multiple of `lanes`.
  std::size_t each() const { return each_; }
  const float* of(std::size_t vertex) const { return &values_[vertex * each_]; }

 private:
  std::size_t each_;
  std::vector<float> values_;
};

/// Makes more vertices points until there are so many: again and again the triangle with the largest sum of squares
/// left is split at its worst vertex, and its vertices keep their places in the parts (barycentrics of the split
/// triangle). Fewer come out where nothing is left.
void add_points(const Remainder& remainder, std::size_t points, ReferenceMesh& mesh);

/// Gives every vertex, of its triangle and those that share a point with it, the one of which a combination comes
/// nearest to it, and the weights of that: they add up to 1, the first two lie in [-1, 2].
void fit_weights(const Remainder& remainder, ReferenceMesh& mesh);

}  // namespace opaline
