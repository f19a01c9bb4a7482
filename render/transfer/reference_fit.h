// Reference points and weights chosen by what they are for: that little is left which the harmonics cannot hold. Hao
// and Varshney name both as future work (2004, section 6).
#pragma once

#include "render/transfer/harmonic_fit.h"
#include "render/transfer/reference_mesh.h"

namespace opaline {

/// What a combination of reference points should reproduce of each vertex, side by side: what the harmonics cannot
/// hold, and, for the dark, the values themselves, whose errors count by what is left beside
///     dark / (value / largest value of the vertex + 0.02)
/// Harmonics that mend a large value a little spoil a small one of the same vertex more than it is: there the points
/// alone must be right, and the harmonics are held to a share of them (CornerBlend::correction).
class Remainder {
 public:
  static constexpr std::size_t lanes = 16;

  Remainder(const TransferTable& table, const HarmonicFit& fit);

  std::size_t vertices() const { return largest_.size(); }
  /// Numbers of one kind, padded with zeros to a multiple of `lanes`.
  std::size_t each() const { return each_; }
  const float* rest(std::size_t vertex) const { return &values_[2 * vertex * each_]; }
  const float* value(std::size_t vertex) const { return rest(vertex) + each_; }
  float largest(std::size_t vertex) const { return largest_[vertex]; }

 private:
  std::size_t each_;
  std::vector<float> values_, largest_;
};

/// Weighted sum of squares that a vertex's triangle and weights leave.
double squares_left(const Remainder& remainder, const ReferenceMesh& mesh, std::size_t vertex);

/// Makes more vertices points until there are so many: again and again the triangle with the largest sum of squares
/// left is split at its worst vertex, and its vertices keep their places in the parts (barycentrics of the split
/// triangle). Fewer come out where nothing is left.
void add_points(const Remainder& remainder, std::size_t points, ReferenceMesh& mesh);

/// Gives every vertex, of its triangle and those that share a point with it, the one of which a combination comes
/// nearest to it, and the weights of that: they add up to 1, the first two lie in [-1, 2].
void fit_weights(const Remainder& remainder, ReferenceMesh& mesh);

}  // namespace opaline
