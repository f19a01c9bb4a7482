// Lloyd's quantiser: the 256 levels that reproduce a set of numbers with the least mean squared error.
//
// Each level is the mean of the numbers nearest to it, and thresholds lie midway between levels (Lloyd 1957, Gersho and
// Gray 1992): a local optimum, found from levels at equal shares of the cube root of the density, which is the best
// there is for many levels.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace opaline {

using Codebook = std::array<float, 256>;

/// Ascending levels for the values, which are reordered. No values: all levels 0.
Codebook lloyd_codebook(std::vector<float>& values);

/// The nearest level's number.
std::uint8_t encode(const Codebook& codebook, float value);

}  // namespace opaline
