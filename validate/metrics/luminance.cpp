#include "validate/metrics/luminance.h"

#include "model/check.h"

namespace opaline {

std::vector<double> luminance(const std::vector<std::vector<float>>& planes) {
  OPALINE_CHECK(planes.size() == 1 || planes.size() == 3);
  if (planes.size() == 1) return {planes[0].begin(), planes[0].end()};
  std::vector<double> y(planes[0].size());
  for (std::size_t p = 0; p < y.size(); ++p)
    y[p] = 0.2126 * static_cast<double>(planes[0][p]) + 0.7152 * static_cast<double>(planes[1][p]) +
           0.0722 * static_cast<double>(planes[2][p]);
  return y;
}

}  // namespace opaline
