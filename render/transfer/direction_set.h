// A uniform set of directions and the interpolation between them: where a transfer function is tabulated.
//
// Direction i of M lies on a spherical Fibonacci lattice (Swinbank, Purser 2006): z = 1 - (2 i + 1)/M, with the golden
// angle from each to the next. Every direction stands for the solid angle 4 pi / M.
//
// Interpolation takes the four nearest directions (Hao, Varshney 2004, section 3.2). They are projected from the
// sphere's centre onto the plane that touches it at w, where they lie at p_k. The weights add up to 1, their p_k to 0
// (a function linear on that plane is exact, so the error is of the second order), and of all such weights the sum of
// |p_k|^2 w_k^2 is smallest: on a direction of the set it has all the weight. Weights may be negative, not below -0.5.
//
// Or it takes the twelve nearest, by moving least squares: the value at w of the quadratic over angle and azimuth
// around w that fits them best, weighted by (1 - (t / t_12)^2)^2 / t^2 at angle t. The error of a smooth function is of
// the third order.
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

enum class DirectionInterpolation { four, twelve };

class DirectionSet {
 public:
  static constexpr int fewest = 20;

  /// count >= fewest, a bug else.
  explicit DirectionSet(int count, DirectionInterpolation interpolation = DirectionInterpolation::four);

  std::size_t size() const { return directions_.size(); }
  const glm::dvec3& operator[](std::size_t i) const { return directions_[i]; }

  /// The nearest directions to a unit vector, nearest first, with weights that add up to 1.
  std::vector<DirectionWeight> around(const glm::dvec3& w) const;

 private:
  template <std::size_t Count>
  std::array<std::uint32_t, Count> nearest(const glm::dvec3& w) const;
  std::vector<DirectionWeight> linear(const glm::dvec3& w) const;
  std::vector<DirectionWeight> quadratic(const glm::dvec3& w) const;
  DirectionInterpolation interpolation_;
  std::vector<glm::dvec3> directions_;
};

}  // namespace opaline
