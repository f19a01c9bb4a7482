// Separable filters of one plane, with the border's pixels repeated outwards.
#pragma once

#include <vector>

namespace opaline {

/// Odd number of weights, the middle one at the pixel itself.
using Kernel = std::vector<double>;

/// Correlates the rows with kernel x and the columns with kernel y.
std::vector<double> filter(const std::vector<double>& plane, int width, int height, const Kernel& x, const Kernel& y);

/// Weights of the formula at -radius .. radius, not normalised.
template <typename Formula>
Kernel kernel_of(int radius, const Formula& formula) {
  Kernel kernel;
  for (int x = -radius; x <= radius; ++x) kernel.push_back(formula(static_cast<double>(x)));
  return kernel;
}

/// The kernel divided by the sum of its weights.
Kernel normalised(Kernel kernel);

}  // namespace opaline
