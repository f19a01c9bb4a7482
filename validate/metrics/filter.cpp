#include "validate/metrics/filter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

namespace opaline {
namespace {

/// Each row correlated with the kernel, written as a column: two calls filter rows, then columns.
std::vector<double> filter_rows_transposed(const std::vector<double>& plane, int width, int height,
                                           const Kernel& kernel) {
  const int radius = static_cast<int>(kernel.size() / 2);
  std::vector<double> result(plane.size());
  tbb::parallel_for(0, height, [&](int y) {
    const double* row = plane.data() + static_cast<std::ptrdiff_t>(y) * width;
    std::vector<double> padded(static_cast<std::size_t>(width + 2 * radius));
    for (int x = -radius; x < width + radius; ++x)
      padded[static_cast<std::size_t>(x + radius)] = row[std::clamp(x, 0, width - 1)];
    for (int x = 0; x < width; ++x)
      result[static_cast<std::size_t>(x) * static_cast<std::size_t>(height) + static_cast<std::size_t>(y)] =
          std::inner_product(kernel.begin(), kernel.end(), padded.begin() + x, 0.0);
  });
  return result;
}

}  // namespace

std::vector<double> filter(const std::vector<double>& plane, int width, int height, const Kernel& x, const Kernel& y) {
  return filter_rows_transposed(filter_rows_transposed(plane, width, height, x), height, width, y);
}

Kernel normalised(Kernel kernel) {
  const double sum = std::accumulate(kernel.begin(), kernel.end(), 0.0);
  for (double& weight : kernel) weight /= sum;
  return kernel;
}

}  // namespace opaline
