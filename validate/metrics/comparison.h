// What of two images is compared: the channels, the pixels, and their values. Metrics (metric.h) are functions of it.
#pragma once

#include "render/image.h"

#include <string>
#include <vector>

namespace opaline {

/// Values of an image and its reference, in the images' units (linear).
struct Comparison {
  int width = 0, height = 0;
  std::vector<std::string> channels;  ///< those compared
  std::vector<std::size_t> pixels;    ///< those compared, y * width + x, ascending
  /// A plane of width * height values for each compared channel; 0 at pixels that aren't compared.
  std::vector<std::vector<float>> image, reference;
  std::size_t pixels_left_out = 0;  ///< by the reference's alpha or by the mask
  /// Pixels inside the mask that one of two images with alpha covers (A > 0) and the other doesn't.
  std::size_t coverage_mismatches = 0;

  /// Are the channels R, G and B?
  bool is_rgb() const { return channels == std::vector<std::string>{"R", "G", "B"}; }
  /// The same pixels of one channel.
  Comparison channel(std::size_t index) const;
};

/// Compares R, G, B of the reference, or all its channels but A if it lacks one of them; the image
/// must have the same. Pixels: those where the reference's A is > 0 (all, if it has no A) and the
/// first channel of `mask` is > 0 (all, if null).
/// Throws InputError("image" | "reference" | "mask", ...) for sizes that differ, a channel that is
/// missing, a value inside the mask that is not finite (naming the first pixel), or no pixel to compare.
Comparison compare_images(const Image& image, const Image& reference, const Image* mask = nullptr);

/// image - reference in the compared channels, and A = 1 at the compared pixels; 0 elsewhere.
Image difference_image(const Comparison& comparison);

}  // namespace opaline
