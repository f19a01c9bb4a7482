// A uniform set of directions and the interpolation between them: where a transfer function is tabulated.
//
// Direction i of M lies on a spherical Fibonacci lattice (Swinbank, Purser 2006): z = 1 - (2 i + 1)/M, with the golden
// angle from each to the next. Every direction stands for the solid angle 4 pi / M.
//
// Interpolation takes the four nearest directions (Hao, Varshney 2004, section 3.2). They are projected from the
// sphere's centre onto the plane that touches it at w, where they lie at p_k. The weights add up to 1, their p_k to 0
// (a function linear on that plane is exact, so the error is of the second order), and of all such weights the sum of
// |p_k|^2 w_k^2 is smallest: on a direction of the set it has all the weight. Weights may be negative, not below -0.5.
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace opaline {

struct DirectionWeight {
  std::uint32_t direction;
  double weight;
};

class DirectionSet {
 public:
  static constexpr int fewest = 20;

  /// count >= fewest, a bug else.
  explicit DirectionSet(int count);

  std::size_t size() const { return directions_.size(); }
  const glm::dvec3& operator[](std::size_t i) const { return directions_[i]; }

  /// The four nearest directions to a unit vector, nearest first, with weights that add up to 1.
  std::array<DirectionWeight, 4> around(const glm::dvec3& w) const;

 private:
  std::array<std::uint32_t, 4> nearest(const glm::dvec3& w) const;
  std::vector<glm::dvec3> directions_;
};

}  // namespace opaline
