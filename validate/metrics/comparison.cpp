#include "validate/metrics/comparison.h"

#include "render/choices.h"
#include "render/input_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// Indices of the compared channels, and of A, in both images.
struct Channels {
  std::vector<int> image, reference;
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

void choose_pixels(const Image& image, const Image& reference, const Image* mask, const Channels& channels,
                   Comparison& comparison) {
  const std::vector<int> image_finite = with_alpha(channels.image, image);
  const std::vector<int> reference_finite = with_alpha(channels.reference, reference);
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
  comparison.pixels_left_out = reference.pixel_count() - comparison.pixels.size();
}

std::vector<std::vector<float>> planes(const Image& image, const std::vector<int>& channels,
                                       const std::vector<std::size_t>& pixels) {
  std::vector<std::vector<float>> result;
  for (const int channel : channels) {
    std::vector<float>& plane = result.emplace_back(image.pixel_count(), 0.0f);
    for (const std::size_t p : pixels) plane[p] = value_at(image, p, channel);
  }
  return result;
}

}  // namespace

Comparison Comparison::channel(std::size_t index) const {
  Comparison one = *this;
  one.channels = {channels[index]};
  one.image = {image[index]};
  one.reference = {reference[index]};
  return one;
}

Comparison compare_images(const Image& image, const Image& reference, const Image* mask) {
  check_size(image, reference, "image");
  if (mask) check_size(*mask, reference, "mask");
  Comparison comparison;
  comparison.width = reference.width;
  comparison.height = reference.height;
  comparison.channels = compared_channels(reference);
  const Channels channels{channel_indices(image, comparison.channels), channel_indices(reference, comparison.channels)};
  choose_pixels(image, reference, mask, channels, comparison);
  comparison.image = planes(image, channels.image, comparison.pixels);
  comparison.reference = planes(reference, channels.reference, comparison.pixels);
  return comparison;
}

Image difference_image(const Comparison& comparison) {
  std::vector<std::string> names = comparison.channels;
  names.push_back("A");
  Image result(comparison.width, comparison.height, names);
  for (const std::size_t p : comparison.pixels) {
    float* out = &result.data[p * names.size()];
    for (std::size_t k = 0; k < comparison.channels.size(); ++k)
      out[k] = comparison.image[k][p] - comparison.reference[k][p];
    out[comparison.channels.size()] = 1;
  }
  return result;
}

}  // namespace opaline
