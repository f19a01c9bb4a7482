#include "render/image_difference.h"

#include "render/choices.h"
#include "render/input_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace opaline {
namespace {

/// Sums over compared values, from which the metrics follow.
struct Sums {
  double count = 0, error = 0, squared_error = 0, squared_reference = 0, max = 0;

  void add(double value, double reference) {
    const double d = value - reference;
    count += 1;
    error += d;
    squared_error += d * d;
    squared_reference += reference * reference;
    max = std::max(max, std::abs(d));
  }
  Sums& operator+=(const Sums& o) {
    count += o.count;
    error += o.error;
    squared_error += o.squared_error;
    squared_reference += o.squared_reference;
    max = std::max(max, o.max);
    return *this;
  }
  DifferenceMetrics metrics() const {
    const double rmse = std::sqrt(squared_error / count), rms = std::sqrt(squared_reference / count);
    const double infinite = std::numeric_limits<double>::infinity();
    return {rmse, rms > 0 ? rmse / rms : (rmse > 0 ? infinite : 0.0), error / count, max};
  }
};

/// What is compared: channel indices of both images, and the pixels.
struct Comparison {
  std::vector<std::string> names;
  std::vector<int> image, reference;
  std::vector<std::size_t> pixels;
  std::size_t coverage_mismatches = 0;
};

float value_at(const Image& image, std::size_t pixel, int channel) {
  return image.data[pixel * image.channels.size() + static_cast<std::size_t>(channel)];
}

void check_size(const Image& image, const Image& reference, const char* name) {
  if (image.width == reference.width && image.height == reference.height) return;
  throw InputError(name, "",
                   fmt::format("is {} x {} pixels, but the reference is {} x {}", image.width, image.height,
                               reference.width, reference.height));
}

void check_finite(const Image& image, std::size_t pixel, const std::vector<int>& channels, const char* name) {
  for (const int c : channels) {
    const float value = value_at(image, pixel, c);
    if (std::isfinite(value)) continue;
    const auto width = static_cast<std::size_t>(image.width);
    throw InputError(
        name, fmt::format("pixel ({}, {})", pixel % width, pixel / width),
        fmt::format("channel {} is {}, which cannot be compared", image.channels[static_cast<std::size_t>(c)], value));
  }
}

std::vector<std::string> compared_channels(const Image& reference) {
  std::vector<std::string> rgb = {"R", "G", "B"};
  if (std::all_of(rgb.begin(), rgb.end(), [&](const auto& name) { return reference.channel(name) >= 0; })) return rgb;
  std::vector<std::string> names;
  for (const std::string& name : reference.channels)
    if (name != "A") names.push_back(name);
  if (names.empty()) throw InputError("reference", "", "has no channel to compare but A");
  return names;
}

std::vector<int> channel_indices(const Image& image, const std::vector<std::string>& names) {
  std::vector<int> indices;
  for (const std::string& name : names) {
    indices.push_back(image.channel(name));
    if (indices.back() < 0) {
      throw InputError("image", "",
                       fmt::format("has no channel {}, which the reference has; its channels: {}", name,
                                   join_names(image.channels)));
    }
  }
  return indices;
}

std::vector<int> with_alpha(std::vector<int> channels, const Image& image) {
  if (image.channel("A") >= 0) channels.push_back(image.channel("A"));
  return channels;
}

void choose_pixels(const Image& image, const Image& reference, const Image* mask, Comparison& comparison) {
  const std::vector<int> image_finite = with_alpha(comparison.image, image);
  const std::vector<int> reference_finite = with_alpha(comparison.reference, reference);
  const int image_alpha = image.channel("A"), reference_alpha = reference.channel("A");
  for (std::size_t p = 0; p < reference.pixel_count(); ++p) {
    if (mask) check_finite(*mask, p, {0}, "mask");
    if (mask && !(value_at(*mask, p, 0) > 0)) continue;
    check_finite(image, p, image_finite, "image");
    check_finite(reference, p, reference_finite, "reference");
    const bool covered = reference_alpha < 0 || value_at(reference, p, reference_alpha) > 0;
    if (reference_alpha >= 0 && image_alpha >= 0)
      comparison.coverage_mismatches += covered != (value_at(image, p, image_alpha) > 0);
    if (covered) comparison.pixels.push_back(p);
  }
  if (comparison.pixels.empty())
    throw InputError("reference", "", "has no pixel to compare: its alpha (or the mask) is 0 everywhere");
}

Comparison make_comparison(const Image& image, const Image& reference, const Image* mask) {
  check_size(image, reference, "image");
  if (mask) check_size(*mask, reference, "mask");
  Comparison comparison;
  comparison.names = compared_channels(reference);
  comparison.image = channel_indices(image, comparison.names);
  comparison.reference = channel_indices(reference, comparison.names);
  choose_pixels(image, reference, mask, comparison);
  return comparison;
}

}  // namespace

ImageDifference compare_images(const Image& image, const Image& reference, const Image* mask) {
  const Comparison comparison = make_comparison(image, reference, mask);
  ImageDifference difference;
  Sums all;
  for (std::size_t k = 0; k < comparison.names.size(); ++k) {
    Sums sums;
    for (const std::size_t p : comparison.pixels) {
      sums.add(static_cast<double>(value_at(image, p, comparison.image[k])),
               static_cast<double>(value_at(reference, p, comparison.reference[k])));
    }
    difference.channel.push_back(sums.metrics());
    all += sums;
  }
  difference.overall = all.metrics();
  difference.channels = comparison.names;
  difference.pixels = comparison.pixels.size();
  difference.pixels_left_out = reference.pixel_count() - comparison.pixels.size();
  difference.coverage_mismatches = comparison.coverage_mismatches;
  return difference;
}

Image difference_image(const Image& image, const Image& reference, const Image* mask) {
  const Comparison comparison = make_comparison(image, reference, mask);
  std::vector<std::string> names = comparison.names;
  names.push_back("A");
  Image result(reference.width, reference.height, names);
  for (const std::size_t p : comparison.pixels) {
    float* out = &result.data[p * names.size()];
    for (std::size_t k = 0; k < comparison.names.size(); ++k)
      out[k] = value_at(image, p, comparison.image[k]) - value_at(reference, p, comparison.reference[k]);
    out[comparison.names.size()] = 1;
  }
  return result;
}

}  // namespace opaline
