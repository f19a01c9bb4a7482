#include "model/cmd/medium_options.h"

#include "model/materials/library.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace opaline {
namespace {

std::vector<Medium<double>> media_of_material(const std::string& name) {
  const MaterialRow* row = find_material(name);
  require_argument(row != nullptr, fmt::format("--material: no material \"{}\"; the library has {}", name,
                                               fmt::join(material_names(), ", ")));
  std::vector<Medium<double>> media;
  for (std::size_t c = 0; c < 3; ++c) media.push_back({row->sigma_a[c], row->sigma_s_prime[c], row->eta});
  return media;
}

void check_coefficients(const char* option, const std::vector<double>& values) {
  require_argument(
      values.size() == 1 || values.size() == 3,
      fmt::format("{}: give one number or three separated by commas, in 1/mm (or name a --material)", option));
  for (const double value : values) {
    require_argument(value >= 0 && value <= 1e90, fmt::format("{}: {} is not in 0 .. 1e90 (1/mm)", option, value));
  }
}

std::vector<Medium<double>> media_of_numbers(const MediumOptions& o) {
  check_coefficients("--sigma-a", o.sigma_a);
  check_coefficients("--sigma-s-prime", o.sigma_s_prime);
  require_argument(o.eta >= 1e-3 && o.eta <= 1e3,
                   "--eta: give a relative index (inside / outside) from 0.001 to 1000, as 1.3");
  require_argument(o.g > -1 && o.g < 1, fmt::format("--g: {} is not between -1 and 1", o.g));
  std::vector<Medium<double>> media;
  const std::size_t channels = std::max(o.sigma_a.size(), o.sigma_s_prime.size());
  for (std::size_t c = 0; c < channels; ++c) {
    const auto at = [&](const std::vector<double>& v) { return v[v.size() == 1 ? 0 : c]; };
    media.push_back({at(o.sigma_a), at(o.sigma_s_prime), o.eta});
    require_argument(media.back().sigma_a + media.back().sigma_s_prime > 1e-90,
                     "--sigma-a, --sigma-s-prime: both are 0; one of them must be above 0");
  }
  return media;
}

}  // namespace

void require_argument(bool good, const std::string& message) {
  if (!good) throw std::invalid_argument(message);
}

std::vector<Medium<double>> media_of(const MediumOptions& o) {
  const bool numbers = !o.sigma_a.empty() || !o.sigma_s_prime.empty() || !std::isnan(o.eta);
  require_argument(o.material.empty() || !numbers,
                   "--material: choose either a material or --sigma-a, --sigma-s-prime and --eta");
  return o.material.empty() ? media_of_numbers(o) : media_of_material(o.material);
}

/// lo, lo + step, ... up to and including hi.
std::vector<double> parse_radii(const std::string& text) {
  double lo = 0, hi = 0, step = 0;
  char rest = 0;
  require_argument(
      std::sscanf(text.c_str(), "%lf:%lf:%lf%c", &lo, &hi, &step, &rest) == 3 && lo >= 0 && hi >= lo && step > 0 &&
          (hi - lo) / step < 1e6,
      fmt::format("--r: \"{}\" is not lo:hi:step in mm with 0 <= lo <= hi, step > 0 and at most a million values, "
                  "as 0:20:0.1",
                  text));
  std::vector<double> radii;
  const int last = static_cast<int>(std::floor((hi - lo) / step * (1 + 1e-12)));
  for (int i = 0; i <= last; ++i) radii.push_back(std::min(lo + i * step, hi));
  return radii;
}

}  // namespace opaline
