#include "model/transport/walk_counts.h"

#include "model/check.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace opaline {
namespace {

constexpr int key_shift = 19;  // 16 keys an octave of r^2

std::size_t key_of(float r2) { return std::bit_cast<std::uint32_t>(r2) >> key_shift; }

void add_to(std::vector<std::uint64_t>& sum, const std::vector<std::uint64_t>& more) {
  for (std::size_t i = 0; i < more.size(); ++i) sum[i] += more[i];
}

}  // namespace

Annuli::Annuli(std::vector<double> radii) : radii_(std::move(radii)) {
  for (const double r : radii_) squared_.push_back(static_cast<float>(r * r));
  if (squared_.empty()) return;
  OPALINE_CHECK(std::is_sorted(squared_.begin(), squared_.end()) && squared_.front() >= 0);
  for (std::size_t key = 0; key <= key_of(squared_.back()); ++key) {
    const auto smallest = std::bit_cast<float>(static_cast<std::uint32_t>(key << key_shift));
    first_.push_back(
        static_cast<std::uint16_t>(std::upper_bound(squared_.begin(), squared_.end(), smallest) - squared_.begin()));
  }
}

std::size_t Annuli::bin(float r2) const {
  if (squared_.empty() || r2 >= squared_.back() || r2 < squared_.front()) return bins() - 1;
  std::size_t edges = first_[key_of(r2)];
  while (r2 >= squared_[edges]) ++edges;
  return edges - 1;
}

void WalkCounts::resize_rows(std::size_t count) {
  killed.resize(count);
  reflected.resize(count * annuli.bins());
  if (std::isfinite(optical_thickness)) transmitted.resize(count * annuli.bins());
}

void WalkCounts::add(const WalkEnds& ends) {
  const std::size_t bins = annuli.bins();
  for (std::size_t i = 0; i < ends.size; ++i) {
    const auto n = static_cast<std::size_t>(ends.key[i] >> WalkEnds::shift);
    const int how = ends.key[i] & ((1 << WalkEnds::shift) - 1);
    if (n >= rows()) resize_rows(n + 1 + rows() / 4);
    if (how == WalkEnds::killed) {
      ++killed[n];
    } else {
      ++(how == WalkEnds::reflected ? reflected : transmitted)[n * bins + annuli.bin(ends.r2[i])];
    }
  }
}

void WalkCounts::add(const WalkCounts& other) {
  OPALINE_CHECK(annuli.bins() == other.annuli.bins() && survival == other.survival);
  if (rows() < other.rows()) resize_rows(other.rows());
  add_to(reflected, other.reflected);
  add_to(transmitted, other.transmitted);
  add_to(killed, other.killed);
  walks += other.walks;
  scatterings += other.scatterings;
}

void WalkCounts::trim() {
  const auto empty = [&](const std::vector<std::uint64_t>& counts, std::size_t row, std::size_t bins) {
    const auto begin = counts.begin() + static_cast<std::ptrdiff_t>(row * bins);
    return std::all_of(begin, begin + static_cast<std::ptrdiff_t>(bins), [](std::uint64_t c) { return c == 0; });
  };
  const std::size_t bins = annuli.bins();
  std::size_t count = rows();
  while (count > 0 && killed[count - 1] == 0 && empty(reflected, count - 1, bins) &&
         (transmitted.empty() || empty(transmitted, count - 1, bins)))
    --count;
  resize_rows(count);
}

}  // namespace opaline
