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

/// Sorted values with running sums, to have means and errors of any part of them at once.
struct Values {
  const std::vector<float>& sorted;
  std::vector<double> sums, squares;

  explicit Values(const std::vector<float>& v) : sorted(v), sums(v.size() + 1, 0.0), squares(v.size() + 1, 0.0) {
    for (std::size_t i = 0; i < v.size(); ++i) {
      const auto x = static_cast<double>(v[i]);
      sums[i + 1] = sums[i] + x, squares[i + 1] = squares[i] + x * x;
    }
  }
  double mean(std::size_t begin, std::size_t end) const {
    return (sums[end] - sums[begin]) / static_cast<double>(end - begin);
  }
  /// Sum of squared distances from the mean.
  double error(std::size_t begin, std::size_t end) const {
    return squares[end] - squares[begin] - (sums[end] - sums[begin]) * mean(begin, end);
  }
};

/// Moves every level to the mean of its values, and one that has none to the top of the worst level's; returns the
/// largest move.
double improve(Codebook& levels, const Values& values) {
  const std::vector<float>& sorted = values.sorted;
  double moved = 0, worst = 0;
  std::size_t begin = 0, empty = levels.size(), top = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    std::size_t end = sorted.size();
    if (i + 1 < levels.size())
      end = static_cast<std::size_t>(std::lower_bound(sorted.begin() + static_cast<std::ptrdiff_t>(begin), sorted.end(),
                                                      0.5f * (levels[i] + levels[i + 1])) -
                                     sorted.begin());
    if (end == begin) {
      empty = i;
      continue;
    }
    const auto mean = static_cast<float>(values.mean(begin, end));
    moved = std::max(moved, static_cast<double>(std::abs(mean - levels[i])));
    levels[i] = mean;
    if (sorted[begin] < sorted[end - 1] && values.error(begin, end) > worst)
      worst = values.error(begin, end), top = end - 1;
    begin = end;
  }
  if (empty == levels.size() || worst <= 0) return moved;
  levels[empty] = sorted[top];
  std::sort(levels.begin(), levels.end());
  return static_cast<double>(sorted.back() - sorted.front());
}

}  // namespace

Codebook lloyd_codebook(std::vector<float>& values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const Values sums(values);
  Codebook levels = companded(values);
  const double still = 1e-7 * static_cast<double>(values.back() - values.front());
  for (int step = 0; step < 1000 && improve(levels, sums) > still;) ++step;
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
