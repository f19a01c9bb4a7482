#include "fit/residual_structure.h"

#include <array>

namespace opaline {

double neighbour_correlation(const Image& difference) {
  const auto width = static_cast<std::size_t>(difference.width);
  double correlation = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    double products = 0, squares = 0, pairs = 0, count = 0;
    const auto value = [&](std::size_t p) { return static_cast<double>(difference.data[4 * p + c]); };
    const auto fitted = [&](std::size_t p) { return difference.data[4 * p + 3] > 0; };
    for (std::size_t p = 0; p < difference.pixel_count(); ++p) {
      if (!fitted(p)) continue;
      squares += value(p) * value(p), ++count;
      const bool right = p % width + 1 < width, below = p + width < difference.pixel_count();
      const std::array<std::size_t, 2> next = {right ? p + 1 : p, below ? p + width : p};
      for (const std::size_t q : next)
        if (q != p && fitted(q)) products += value(p) * value(q), ++pairs;
    }
    if (squares > 0 && pairs > 0) correlation += products / pairs / (squares / count) / 3;
  }
  return correlation;
}

}  // namespace opaline
