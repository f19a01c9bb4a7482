// Numerical stability, measured: every registered formula in double against the same formula in 100 digits.
//
// The error of a value y at inputs x is counted in units of the last place (ULP) of the exact value f and divided by
// 1 + condition, condition = sum_i |x_i f_i(x)/f(x)|: what the rounding of the inputs alone may cost is not the
// formula's fault. Derivatives (dual numbers) are functions of their own, with their own condition, against differences
// in 100 digits; where one is what is left over from terms of the size of f over the input's scale, in ULP of that.
// Beyond that every value must be finite, and non-negative and monotone where the function is.
//
// To add a function: one row in fresnel_functions.cpp, profile_functions.cpp, sampling_functions.cpp or, for a path in
// floats, whose errors count in units of a float's last place, float_functions.cpp. A profile of the registry gets a
// row of validity checks by itself.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace opaline {

struct StressOptions {
  std::uint64_t count = 100000;  ///< random inputs in double per function, for the invalid values
  std::uint64_t points = 1500;   ///< random inputs in 100 digits per function; beside them the combinations of corners
  std::uint64_t seed = 1;        ///< same seed, same result, for any number of threads
  int threads = 0;               ///< 0: one per processor
  std::string only;              ///< functions whose name contains this; empty: all
};

/// A number and the inputs that gave it.
struct WorstCase {
  double value = 0;
  double condition = 0;
  std::vector<double> at;  ///< empty: never above 0
};

/// One row: a function, or its derivatives.
struct StressResult {
  std::string name;
  std::string domain;               ///< in words
  std::vector<std::string> inputs;  ///< names
  bool derivative = false;
  std::uint64_t points = 0;  ///< compared with 100 digits; 0: only checked
  std::uint64_t dark = 0;    ///< of these below 1e-280, where doubles lose digits: checked to be small and not compared
  WorstCase scaled;          ///< worst ULP/(1 + condition)
  WorstCase plain;           ///< worst ULP
  double limit = 0;          ///< of scaled.value
  std::uint64_t checked = 0, nan = 0, infinite = 0, negative = 0, not_monotone = 0;
  std::vector<double> invalid_at;  ///< inputs of the first invalid value

  std::uint64_t invalid() const { return nan + infinite + negative + not_monotone; }
  bool passed() const { return invalid() == 0 && scaled.value <= limit; }
};

/// Names of the registered functions.
std::vector<std::string> stress_function_names();

/// Rows in the order of the registry, a function's derivatives after it.
std::vector<StressResult> run_stress(const StressOptions& options);

}  // namespace opaline
