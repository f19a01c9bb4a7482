// Where a function is stressed: one axis per input with its hard corners and its random range.
#pragma once

#include "model/transport/split_mix.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace opaline {

constexpr std::size_t most_inputs = 6;
using Input = std::array<double, most_inputs>;  ///< the first axes.size() numbers count

enum class Spread {
  logarithmic,   ///< log-uniform in [low, high], low > 0
  linear,        ///< uniform in [low, high]
  share,         ///< in [0, 1): half log-uniform from `low`, half 1 - log-uniform from 2^-53
  signed_share,  ///< in (-1, 1): a share with a random sign, up to 1 - `low`
  around_one,    ///< half log-uniform in [low, high], half 1 +- log-uniform from 1e-15 to 0.1
};

struct Axis {
  std::string name;
  std::vector<double> corners;
  double low = 0, high = 1;
  Spread spread = Spread::logarithmic;
};

/// Axes, and how they become the function's inputs.
struct Domain {
  std::vector<Axis> axes;
  void (*to_inputs)(Input&) = nullptr;           ///< nullptr: axes are inputs
  bool (*valid)(const Input& inputs) = nullptr;  ///< nullptr: all are; others are left out
  std::vector<std::string> inputs = {};          ///< their names; empty: the axes'
  std::size_t hold = 1;  ///< random points in a row that differ in the last axis only, for costly preparations

  std::size_t dimension() const { return axes.size(); }
  const std::string& input_name(std::size_t i) const { return inputs.empty() ? axes[i].name : inputs[i]; }
  Input inputs_at(Input axis_values) const;
  bool contains(const Input& input) const { return valid == nullptr || valid(input); }
};

/// Every combination of corners, as axis values.
std::vector<Input> corner_points(const Domain& domain);

/// Axis values at random, an eighth of them corners; `before` is kept up to its last axis if `keep`.
Input random_point(const Domain& domain, SplitMix& random, const Input& before, bool keep);

/// Uniform in [0, 1), 53 bits.
double uniform(SplitMix& random);

/// Log-uniform in [low, high].
double log_uniform(SplitMix& random, double low, double high);

/// "eta .3 .. 3.5 and 1, 0.999999999": one text for all axes.
std::string describe(const Domain& domain);

}  // namespace opaline
