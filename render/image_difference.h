// How far an image is from its reference: the numbers `opaline compare` prints and a fit reports.
#pragma once

#include "render/image.h"

#include <string>
#include <vector>

namespace opaline {

/// d = image - reference over the compared values, in the images' units.
struct DifferenceMetrics {
  double rmse = 0;           ///< sqrt(mean d^2)
  double relative_rmse = 0;  ///< rmse / sqrt(mean reference^2); both 0: 0, only the reference 0: infinite
  double mean_error = 0;     ///< mean d: > 0 where the image is too bright
  double max = 0;            ///< largest |d|
};

struct ImageDifference {
  DifferenceMetrics overall;               ///< all compared pixels and channels as one set
  std::vector<std::string> channels;       ///< those compared
  std::vector<DifferenceMetrics> channel;  ///< one each, relative to that channel of the reference
  std::size_t pixels = 0;                  ///< compared
  std::size_t pixels_left_out = 0;         ///< by the reference's alpha or by the mask
  /// Pixels inside the mask that one of two images with alpha covers (A > 0) and the other doesn't.
  std::size_t coverage_mismatches = 0;
};

/// Compares R, G, B of the reference, or all its channels but A if it lacks one of them; the image
/// must have the same. Pixels: those where the reference's A is > 0 (all, if it has no A) and the
/// first channel of `mask` is > 0 (all, if null).
/// Throws InputError("image" | "reference" | "mask", ...) for sizes that differ, a channel that is
/// missing, a value inside the mask that is not finite (naming the first pixel), or no pixel to compare.
ImageDifference compare_images(const Image& image, const Image& reference, const Image* mask = nullptr);

/// image - reference in the compared channels, and A = 1 at the compared pixels; 0 elsewhere.
/// Throws as compare_images.
Image difference_image(const Image& image, const Image& reference, const Image* mask = nullptr);

}  // namespace opaline
