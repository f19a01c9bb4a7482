#include "render/layered/layered_choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace opaline {
namespace {

/// Of a picked number of layers: more cost more than the hierarchical gather.
constexpr int most_layers = 64;

/// The coarsest grid on which the profile's spectrum has fallen to `left` of its total at the highest frequency.
double coarsest_nodes_per_pixel(const PlaneSpectrum& spectrum, double pixel, double left) {
  const double total = spectrum(0, 0);
  for (double nodes = 1.0 / 64; nodes < 4; nodes *= 2)
    if (spectrum(pi * nodes / pixel, 0) <= left * total) return nodes;
  return 4;
}

int layers_for(double error, double depth, double spread) {
  const double gap = 55 * error * spread;
  return std::clamp(1 + static_cast<int>(std::ceil(depth / gap)), 4, most_layers);
}

}  // namespace

double spread_length(const PlaneSpectrum& spectrum) {
  const double total = spectrum(0, 0);
  if (!(total > 0)) return 1;
  double lo = 1e-9, hi = 1e9;  // k [1/mm]
  for (int i = 0; i < 60; ++i) {
    const double k = std::sqrt(lo * hi);
    (spectrum(k, 0) > total * std::exp(-1.0) ? lo : hi) = k;
  }
  return 1 / lo;
}

LayeredChoice choose(const LayeredSettings& settings, const std::vector<PlaneSpectrum>& spectra, double depth,
                     double pixel) {
  LayeredChoice choice{settings.layers, settings.threshold, {}, {}};
  const double error = settings.automatic ? settings.wanted_error : 0.005;
  if (settings.automatic) {
    double spread = HUGE_VAL;
    for (const PlaneSpectrum& s : spectra) spread = std::min(spread, spread_length(s));
    choice.layers = layers_for(error, depth, spread);
    choice.threshold = 1e-3 * error;
  }
  std::vector<std::string> percent;
  for (const PlaneSpectrum& s : spectra) {
    const bool pick = settings.automatic || settings.nodes_per_pixel == 0;
    choice.nodes_per_pixel.push_back(pick ? coarsest_nodes_per_pixel(s, pixel, 3 * error) : settings.nodes_per_pixel);
    percent.push_back(fmt::format("{:.4g}", 100 * choice.nodes_per_pixel.back()));
  }
  choice.note = fmt::format("{} layers, threshold {:.2g}, resolution {} %", choice.layers, choice.threshold,
                            fmt::join(percent, ", "));
  return choice;
}

}  // namespace opaline
