#include "reports/format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace opaline {
namespace {

constexpr const char* not_finite = "not finite";

/// Three digits, and never an exponent where the value has at most six places.
std::string digits(double value) {
  const double size = std::abs(value);
  if (size >= 100 && size < 1e6) return fmt::format("{:.0f}", value);
  return fmt::format("{:.3g}", value);
}

struct Unit {
  double size;
  const char* name;
};

template <std::size_t n>
std::string with_unit(double value, const std::array<Unit, n>& largest_first) {
  for (const Unit& unit : largest_first)
    if (std::abs(value) >= unit.size) return digits(value / unit.size) + unit.name;
  return digits(value / largest_first.back().size) + largest_first.back().name;
}

}  // namespace

std::string seconds_text(double seconds) {
  if (!std::isfinite(seconds)) return not_finite;
  if (seconds == 0) return "0";
  return with_unit(seconds, std::array<Unit, 4>{{{1, " s"}, {1e-3, " ms"}, {1e-6, " µs"}, {1e-9, " ns"}}});
}

std::string relative_text(double value) {
  if (!std::isfinite(value)) return not_finite;
  if (value == 0) return "0";
  return std::abs(value) >= 1e-4 ? digits(100 * value) + " %" : fmt::format("{:.1e}", value);
}

std::string number_text(double value) { return std::isfinite(value) ? digits(value) : not_finite; }

std::string count_text(std::uint64_t count) {
  if (count < 10'000) return std::to_string(count);
  return with_unit(static_cast<double>(count), std::array<Unit, 3>{{{1e9, " G"}, {1e6, " M"}, {1e3, " k"}}});
}

std::string bytes_text(std::uint64_t bytes) {
  return with_unit(static_cast<double>(bytes),
                   std::array<Unit, 4>{{{1e9, " GB"}, {1e6, " MB"}, {1e3, " kB"}, {1, " B"}}});
}

std::string words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

}  // namespace opaline
