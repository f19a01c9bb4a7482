#include "reports/pictures.h"

#include "render/input_error.h"
#include "render/srgb.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace opaline {
namespace {

using Colour = std::array<double, 3>;

/// The colour map viridis (van der Walt and Smith, 2015; CC0) at nine equal steps, in sRGB: lightness grows evenly, so
/// it reads in grey and with any colour vision.
constexpr std::array<Colour, 9> viridis = {{{68, 1, 84},
                                            {71, 44, 122},
                                            {59, 81, 139},
                                            {44, 113, 142},
                                            {33, 144, 141},
                                            {39, 173, 129},
                                            {92, 200, 99},
                                            {170, 220, 50},
                                            {253, 231, 37}}};

Colour viridis_at(double t) {
  const double at = std::clamp(t, 0.0, 1.0) * (viridis.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), viridis.size() - 2);
  const double f = at - static_cast<double>(i);
  Colour mix;
  for (std::size_t c = 0; c < 3; ++c) mix[c] = viridis[i][c] * (1 - f) + viridis[i + 1][c] * f;
  return mix;
}

std::uint8_t byte(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

std::array<int, 3> rgb_channels(const Image& image) {
  return {image.channel("R"), image.channel("G"), image.channel("B")};
}

void check_rgb(const Image& image, const char* what) {
  for (const int c : rgb_channels(image))
    if (c < 0) throw InputError(what, "", "lacks one of the channels R, G, B");
}

/// Is the pixel part of the object?
bool covered(const Image& image, int x, int y) {
  const int alpha = image.channel("A");
  return alpha < 0 || image.at(x, y, alpha) > 0;
}

/// value(x, y, channel) per pixel, squared and averaged over R, G and B; rooted, over `scale`.
template <typename Square>
Image per_pixel(const Image& reference, double scale, Square square) {
  Image out(reference.width, reference.height, {"Y", "A"});
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      if (!covered(reference, x, y)) continue;
      const double sum = square(x, y, 0u) + square(x, y, 1u) + square(x, y, 2u);
      out.at(x, y, 0) = static_cast<float>(std::sqrt(sum / 3) / scale);
      out.at(x, y, 1) = 1;
    }
  }
  return out;
}

void check_sizes(const Image& image, const Image& reference) {
  if (image.width != reference.width || image.height != reference.height)
    throw InputError("image", "",
                     fmt::format("is {} x {} pixels, its reference {} x {}", image.width, image.height, reference.width,
                                 reference.height));
  check_rgb(image, "image");
  check_rgb(reference, "reference");
}

std::string png(int width, int height, int channels, const std::vector<std::uint8_t>& bytes) {
  OIIO::Filesystem::IOVecOutput file;
  const auto output = OIIO::ImageOutput::create("memory.png", &file);
  OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("png:compressionLevel", 9);
  const bool done = output && output->open("memory.png", spec) &&
                    output->write_image(OIIO::TypeDesc::UINT8, bytes.data()) && output->close();
  if (!done)
    throw std::runtime_error("OpenImageIO cannot make a PNG: " + (output ? output->geterror() : OIIO::geterror()));
  return {file.buffer().begin(), file.buffer().end()};
}

/// Mean of channel c over the source pixels [x0, x1) x [y0, y1).
float mean(const Image& image, int x0, int x1, int y0, int y1, int c) {
  double sum = 0;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) sum += static_cast<double>(image.at(x, y, c));
  return static_cast<float>(sum / (static_cast<double>(x1 - x0) * (y1 - y0)));
}

}  // namespace

Image shrunk(const Image& image, int max_side) {
  const int longer = std::max(image.width, image.height);
  if (longer <= max_side) return image;
  const auto size = [&](int side) {
    return std::max(1, static_cast<int>(std::lround(double(side) * max_side / longer)));
  };
  Image out(size(image.width), size(image.height), image.channels);
  const auto edge = [](int i, int n, int of) { return static_cast<int>(static_cast<std::int64_t>(i) * of / n); };
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int c = 0; c < out.channel_count(); ++c)
        out.at(x, y, c) = mean(image, edge(x, out.width, image.width), edge(x + 1, out.width, image.width),
                               edge(y, out.height, image.height), edge(y + 1, out.height, image.height), c);
  return out;
}

double rms(const Image& image) {
  check_rgb(image, "image");
  double sum = 0;
  std::size_t count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (!covered(image, x, y)) continue;
      for (const int c : rgb_channels(image)) sum += std::pow(static_cast<double>(image.at(x, y, c)), 2);
      count += 3;
    }
  }
  return count == 0 ? 0 : std::sqrt(sum / static_cast<double>(count));
}

Image relative_error(const Image& image, const Image& reference, double scale) {
  check_sizes(image, reference);
  const auto a = rgb_channels(image), b = rgb_channels(reference);
  return per_pixel(reference, scale, [&](int x, int y, std::size_t c) {
    return std::pow(static_cast<double>(image.at(x, y, a[c])) - static_cast<double>(reference.at(x, y, b[c])), 2);
  });
}

Image relative_size(const Image& image, const Image& reference, double scale, bool squared) {
  check_sizes(image, reference);
  const auto a = rgb_channels(image);
  return per_pixel(reference, scale, [&](int x, int y, std::size_t c) {
    const double value = static_cast<double>(image.at(x, y, a[c]));
    return squared ? value : value * value;
  });
}

std::string tonemapped_png(const Image& image, double exposure) {
  check_rgb(image, "image");
  std::vector<std::uint8_t> bytes;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (const int c : rgb_channels(image)) {
        const double value = exposure * static_cast<double>(image.at(x, y, c));
        bytes.push_back(value > 0 ? byte(255 * srgb_from_linear(std::min(value, 1.0))) : std::uint8_t{0});
      }
  return png(image.width, image.height, 3, bytes);
}

std::string false_colour_png(const Image& relative) {
  const double low = std::log10(false_colour_low), range = std::log10(false_colour_high) - low;
  std::vector<std::uint8_t> bytes;
  for (std::size_t p = 0; p < relative.pixel_count(); ++p) {
    const double value = static_cast<double>(relative.data[2 * p]);
    const Colour colour =
        !std::isfinite(value) ? Colour{255, 0, 255} : viridis_at((std::log10(std::max(value, 1e-30)) - low) / range);
    for (const double c : colour) bytes.push_back(byte(c));
    bytes.push_back(relative.data[2 * p + 1] > 0 ? 255 : 0);
  }
  return png(relative.width, relative.height, 4, bytes);
}

std::string false_colour_gradient() {
  std::string stops;
  for (const Colour& c : viridis) stops += fmt::format(", rgb({:.0f} {:.0f} {:.0f})", c[0], c[1], c[2]);
  return "linear-gradient(to right" + stops + ")";
}

std::string data_uri(const std::string& png) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out = "data:image/png;base64,";
  for (std::size_t i = 0; i < png.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < png.size() ? static_cast<unsigned char>(png[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k <= png.size() ? digits[three >> (18 - 6 * k) & 63u] : '=';
  }
  return out;
}

}  // namespace opaline
