// Order along a Morton curve: neighbours in space become neighbours in memory.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace opaline {

/// A point's code (20 bits an axis) and its index.
struct MortonKey {
  std::uint64_t code;
  std::uint32_t index;
};

/// The points through their bounding box's Morton curve; equal codes keep the order of the points.
std::vector<MortonKey> morton_sorted(std::span<const glm::vec3> points);

/// Where to cut sorted keys in two (at least two keys): at the plane of the smallest octree cell that holds them; in
/// the middle if all codes are equal.
std::size_t morton_split(std::span<const MortonKey> keys);

/// Cuts sorted keys until no piece has more than `most`; appends the pieces' sizes, in order.
void morton_pieces(std::span<const MortonKey> keys, std::size_t most, std::vector<std::size_t>& sizes);

}  // namespace opaline
