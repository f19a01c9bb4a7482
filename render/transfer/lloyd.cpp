#include "render/transfer/lloyd.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// Levels at equal shares of the integral of density^(1/3), from the sorted values' quantiles.
Codebook companded(const std::vector<float>& sorted) {
  constexpr std::size_t pieces = 1024;
  const std::size_t n = sorted.size();
  const auto quantile = [&](std::size_t k) { return static_cast<double>(sorted[k * (n - 1) / pieces]); };
  std::vector<double> share(pieces + 1, 0.0);
  for (std::size_t k = 0; k < pieces; ++k)  // density ~ 1 / width, so the integral of its cube root ~ width^(2/3)
    share[k + 1] = share[k] + std::cbrt(std::pow(quantile(k + 1) - quantile(k), 2));
  Codebook levels;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double target = share[pieces] * (static_cast<double>(i) + 0.5) / static_cast<double>(levels.size());
    const auto k =
        static_cast<std::size_t>(std::lower_bound(share.begin() + 1, share.end() - 1, target) - share.begin());
    const double width = share[k] - share[k - 1], place = width > 0 ? (target - share[k - 1]) / width : 0.5;
    levels[i] = static_cast<float>(quantile(k - 1) + place * (quantile(k) - quantile(k - 1)));
  }
  return levels;
}

/// Moves every level to the mean of its values; returns the largest move.
double improve(Codebook& levels, const std::vector<float>& sorted, const std::vector<double>& sums) {
  double moved = 0;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    std::size_t end = sorted.size();
    if (i + 1 < levels.size()) {
      const float threshold = 0.5f * (levels[i] + levels[i + 1]);
      end = static_cast<std::size_t>(
          std::lower_bound(sorted.begin() + static_cast<std::ptrdiff_t>(begin), sorted.end(), threshold) -
          sorted.begin());
    }
    if (end > begin) {
      const auto mean = static_cast<float>((sums[end] - sums[begin]) / static_cast<double>(end - begin));
      moved = std::max(moved, static_cast<double>(std::abs(mean - levels[i])));
      levels[i] = mean;
    }
    begin = end;
  }
  return moved;
}

}  // namespace

Codebook lloyd_codebook(std::vector<float>& values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  std::vector<double> sums(values.size() + 1, 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + static_cast<double>(values[i]);
  Codebook levels = companded(values);
  const double still = 1e-7 * static_cast<double>(values.back() - values.front());
  for (int step = 0; step < 1000 && improve(levels, values, sums) > still;) ++step;
  std::sort(levels.begin(), levels.end());
  return levels;
}

std::uint8_t encode(const Codebook& codebook, float value) {
  const auto above = std::lower_bound(codebook.begin(), codebook.end(), value);
  auto i = static_cast<std::size_t>(above - codebook.begin());
  if (i == codebook.size()) return static_cast<std::uint8_t>(i - 1);
  if (i > 0 && value - codebook[i - 1] <= codebook[i] - value) --i;
  return static_cast<std::uint8_t>(i);
}

}  // namespace opaline
