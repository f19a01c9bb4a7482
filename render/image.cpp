#include "render/image.h"

#include "model/check.h"
#include "render/file.h"
#include "render/input_error.h"
#include "render/srgb.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>

namespace opaline {
namespace {

/// OpenImageIO's messages may span lines; ours are one line.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "no reason given" : text;
}

void check_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw InputError(path, "", "the file does not exist");
  if (std::filesystem::is_directory(path, error)) throw InputError(path, "", "is a folder, not a file");
  const auto size = std::filesystem::file_size(path, error);
  if (!error && size == 0) throw InputError(path, "", "the image file is empty");
}

std::unique_ptr<OIIO::ImageInput> open_image(const std::string& path) {
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // values as stored: no multiplication by alpha
  auto input = OIIO::ImageInput::open(path, &config);
  if (!input) throw InputError(path, "", "cannot be read as an image: " + one_line(OIIO::geterror()));
  return input;
}

/// Writes rows of `Value` through OpenImageIO to a file of the spec's format.
template <typename Value>
void write_rows(const std::string& path, const OIIO::ImageSpec& spec, const std::vector<Value>& data) {
  const auto output = OIIO::ImageOutput::create(path);
  if (!output) throw std::runtime_error(one_line(OIIO::geterror()));
  const OIIO::TypeDesc type = OIIO::BaseTypeFromC<Value>::value;
  const bool done = output->open(path, spec) && output->write_image(type, data.data()) && output->close();
  if (!done) throw std::runtime_error(one_line(output->geterror()));
}

void check_writable(const std::string& path, const Image& image, const std::string& extension) {
  if (std::filesystem::path(path).extension() != extension) {
    throw InputError(path, "", "cannot be written: the name must end in " + extension);
  }
  if (image.width < 1 || image.height < 1 || image.channels.empty()) {
    throw InputError(path, "", "cannot be written: the image has no pixels");
  }
}

std::uint8_t to_srgb8(double linear) {
  if (!(linear > 0)) return 0;  // NaN too: a preview has no code for it
  return static_cast<std::uint8_t>(std::lround(255 * srgb_from_linear(std::min(linear, 1.0))));
}

/// Channels a preview shows: R, G, B, or the first channel as grey.
std::vector<int> preview_channels(const Image& image) {
  const std::vector<int> rgb = {image.channel("R"), image.channel("G"), image.channel("B")};
  return *std::min_element(rgb.begin(), rgb.end()) >= 0 ? rgb : std::vector<int>{0};
}

}  // namespace

Image::Image(int w, int h, std::vector<std::string> names) : width(w), height(h), channels(std::move(names)) {
  data.assign(pixel_count() * channels.size(), 0.0f);
}

int Image::channel(const std::string& name) const {
  const auto it = std::find(channels.begin(), channels.end(), name);
  return it == channels.end() ? -1 : static_cast<int>(it - channels.begin());
}

Image with_layers(const Image& image, const std::map<std::string, Image>& layers) {
  std::vector<std::string> names = image.channels;
  for (const auto& [layer, other] : layers) {
    OPALINE_CHECK(other.width == image.width && other.height == image.height);
    for (const std::string& channel : other.channels) names.push_back(layer + "." + channel);
  }
  Image all(image.width, image.height, names);
  auto out = all.data.begin();
  const auto copy_pixel = [&](const Image& from, std::size_t p) {
    const auto first = from.data.begin() + static_cast<std::ptrdiff_t>(p * from.channels.size());
    out = std::copy(first, first + from.channel_count(), out);
  };
  for (std::size_t p = 0; p < image.pixel_count(); ++p) {
    copy_pixel(image, p);
    for (const auto& [layer, other] : layers) copy_pixel(other, p);
  }
  return all;
}

Image read_image(const std::string& path) {
  check_file(path);
  const auto input = open_image(path);
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) throw InputError(path, "", "the image has no pixels");
  Image image(spec.width, spec.height, spec.channelnames);
  const bool read = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.data.data());
  // TIFF and JPEG report a file that ends early but return true.
  if (!read || input->has_error()) {
    throw InputError(path, "", "the image is damaged or ends early: " + one_line(input->geterror()));
  }
  return image;
}

void write_exr(const std::string& path, const Image& image, const std::map<std::string, std::string>& header) {
  check_writable(path, image, ".exr");
  OIIO::ImageSpec spec(image.width, image.height, image.channel_count(), OIIO::TypeDesc::FLOAT);
  spec.channelnames = image.channels;
  spec.alpha_channel = image.channel("A");
  spec.attribute("compression", "zip");
  for (const auto& [name, value] : header) spec.attribute(name, value);
  write_file_atomically(path, [&](const std::string& temporary) { write_rows(temporary, spec, image.data); });
}

void write_png(const std::string& path, const Image& image, double exposure) {
  check_writable(path, image, ".png");
  const std::vector<int> shown = preview_channels(image);
  std::vector<std::uint8_t> bytes;
  bytes.reserve(image.pixel_count() * shown.size());
  for (std::size_t p = 0; p < image.pixel_count(); ++p) {
    for (int c : shown) {
      const float value = image.data[p * image.channels.size() + static_cast<std::size_t>(c)];
      bytes.push_back(to_srgb8(exposure * static_cast<double>(value)));
    }
  }
  OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(shown.size()), OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  write_file_atomically(path, [&](const std::string& temporary) { write_rows(temporary, spec, bytes); });
}

double auto_exposure(const Image& image) {
  std::vector<float> brightest;
  for (std::size_t p = 0; p < image.pixel_count(); ++p) {
    float most = 0;
    for (int c : preview_channels(image))
      most = std::max(most, image.data[p * image.channels.size() + static_cast<std::size_t>(c)]);
    if (std::isfinite(most)) brightest.push_back(most);
  }
  if (brightest.empty()) return 1;
  const auto rank = brightest.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(brightest.size() - 1));
  std::nth_element(brightest.begin(), rank, brightest.end());
  // A small lit spot on black: its peak stands in for the percentile.
  const float reference = *rank > 0 ? *rank : *std::max_element(brightest.begin(), brightest.end());
  return reference > 0 ? 0.9 / static_cast<double>(reference) : 1;
}

}  // namespace opaline
