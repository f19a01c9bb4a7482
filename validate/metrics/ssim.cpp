// Structural similarity: Wang, Bovik, Sheikh, Simoncelli 2004, "Image Quality Assessment: From Error Visibility to
// Structural Similarity", of what a display would show: luminance, exposed by the reference, as sRGB.
#include "render/srgb.h"
#include "validate/metrics/filter.h"
#include "validate/metrics/luminance.h"
#include "validate/metrics/metric.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using Plane = std::vector<double>;

/// Exposure that puts the 99th percentile of the reference at 0.9; 1 where that is black.
double exposure(const Plane& reference, const std::vector<std::size_t>& pixels) {
  Plane values;
  for (const std::size_t p : pixels) values.push_back(reference[p]);
  const auto rank = static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  const double bright = values[static_cast<std::size_t>(rank)];
  return bright > 0 ? 0.9 / bright : 1;
}

Plane displayed(Plane values, double scale) {
  for (double& v : values) v = srgb_from_linear(std::clamp(scale * v, 0.0, 1.0));
  return values;
}

Plane product(const Plane& a, const Plane& b) {
  Plane result(a.size());
  for (std::size_t p = 0; p < a.size(); ++p) result[p] = a[p] * b[p];
  return result;
}

double evaluate(const Comparison& c) {
  const Plane reference = luminance(c.reference);
  const double scale = exposure(reference, c.pixels);
  const Plane x = displayed(luminance(c.image), scale), y = displayed(reference, scale);
  const Kernel window = normalised(kernel_of(5, [](double t) { return std::exp(-t * t / (2 * 1.5 * 1.5)); }));
  const auto mean = [&](const Plane& plane) { return filter(plane, c.width, c.height, window, window); };
  const Plane mx = mean(x), my = mean(y), xx = mean(product(x, x)), yy = mean(product(y, y)), xy = mean(product(x, y));
  constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
  double sum = 0;
  for (const std::size_t p : c.pixels) {
    const double covariance = xy[p] - mx[p] * my[p], variances = xx[p] - mx[p] * mx[p] + yy[p] - my[p] * my[p];
    sum += (2 * mx[p] * my[p] + c1) * (2 * covariance + c2) / ((mx[p] * mx[p] + my[p] * my[p] + c1) * (variances + c2));
  }
  return sum / static_cast<double>(c.pixels.size());
}

}  // namespace

Metric ssim_metric() {
  return {.name = "ssim",
          .formula =
              "mean SSIM (Wang et al. 2004; Gaussian window 11 x 11, sigma 1.5, C1 = 0.01^2, C2 = 0.03^2) of the "
              "luminance as sRGB, exposed so that the reference's 99th percentile is 0.9",
          .better = Metric::Better::one,
          .needs_rgb = true,
          .evaluate = evaluate};
}

}  // namespace opaline
