#include "model/stress/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace opaline {
namespace {

using WideInput = std::array<Wide, most_inputs>;

Wide evaluate(const StressFunction& row, const WideInput& x) { return row.reference(x.data()); }

WideInput widen(const Input& input) {
  WideInput x;
  for (std::size_t i = 0; i < most_inputs; ++i) x[i] = input[i];
  return x;
}

/// x with input i moved up by `relative` of itself, and by how much.
Wide moved(WideInput& x, std::size_t i, const Wide& relative) {
  Wide step = x[i] == 0 ? Wide(relative * Wide("1e-20")) : Wide(abs(x[i]) * relative);
  x[i] += step;
  return step;
}

/// One-sided: 100 digits leave 50 of the derivative, and the side is the stated one at a kink.
Wide slope(const StressFunction& row, WideInput x, const Wide& value, std::size_t by, const char* relative = "1e-45") {
  const Wide step = moved(x, by, Wide(relative));
  return (evaluate(row, x) - value) / step;
}

/// The slope, or 0 if it only shrinks with the step: the function is flat there.
Wide slope_or_flat(const StressFunction& row, const WideInput& x, const Wide& value, std::size_t by) {
  const Wide derivative = slope(row, x, value, by);
  return abs(slope(row, x, value, by, "1e-40")) > 100 * abs(derivative) ? Wide(0) : derivative;
}

double ratio(const Wide& part, const Wide& whole) {
  return whole == 0 ? 0.0 : static_cast<double>(Wide(abs(Wide(part / whole))));
}

}  // namespace

Exact exact_value(const StressFunction& row, const Input& input) {
  const WideInput x = widen(input);
  const Wide value = evaluate(row, x);
  Exact exact{value, Wide(abs(value)), 0};
  for (std::size_t i = 0; i < row.domain.dimension(); ++i) {
    if (input[i] != 0) exact.condition += ratio(Wide(x[i] * slope(row, x, value, i)), exact.size);
  }
  return exact;
}

Exact exact_derivative(const StressFunction& row, const Input& input, std::size_t by) {
  const WideInput x = widen(input);
  const Wide value = evaluate(row, x), derivative = slope_or_flat(row, x, value, by);
  Exact exact{derivative, Wide(abs(derivative)), 0};
  if (row.gradient_scale != nullptr) {
    exact.size = std::max(exact.size, Wide(abs(value) / row.gradient_scale(input, by)));
  }
  for (std::size_t i = 0; i < row.domain.dimension(); ++i) {
    if (input[i] == 0) continue;
    WideInput beside = x;
    const Wide step = moved(beside, i, Wide("1e-15"));
    const Wide change = slope_or_flat(row, beside, evaluate(row, beside), by) - derivative;
    exact.condition += ratio(Wide(x[i] * change / step), exact.size);
  }
  return exact;
}

double ulp_at(double value) {
  const double size = std::abs(value);
  return std::nextafter(size, std::numeric_limits<double>::infinity()) - size;
}

double ulp_error(double value, const Exact& exact) {
  const Wide error = abs(Wide(value - exact.value));
  if (exact.size == 0) return error == 0 ? 0.0 : std::numeric_limits<double>::infinity();
  return static_cast<double>(Wide(error / ulp_at(static_cast<double>(exact.size))));
}

}  // namespace opaline
