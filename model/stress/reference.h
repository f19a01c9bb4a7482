// What 100 digits say about a row at one input: value, derivative, condition.
#pragma once

#include "model/stress/function.h"

namespace opaline {

struct Exact {
  Wide value;
  Wide size;         ///< what its error is counted against: |value|, or more
  double condition;  ///< sum_i |x_i f_i|/size
};

/// The value at `input`; its condition by forward differences, good to 1e-15 and more.
Exact exact_value(const StressFunction& row, const Input& input);

/// The derivative by input `by`, for eta -> 1+ and sigma_a -> 0+ where it differs by side; with its own condition.
/// size is at least |f/gradient_scale| if the row has one.
Exact exact_derivative(const StressFunction& row, const Input& input, std::size_t by);

/// Spacing of doubles at |value|.
double ulp_at(double value);

/// |value - exact| in units of the last place of exact.size; infinite if that is 0 and value isn't.
double ulp_error(double value, const Exact& exact);

}  // namespace opaline
