// Float images and their files.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace opaline {

/// Row-major, top row first, channels interleaved.
struct Image {
  int width = 0, height = 0;
  std::vector<std::string> channels;  ///< "R", "G", "B", "A", ...
  std::vector<float> data;            ///< width * height * channels.size()

  Image() = default;
  Image(int w, int h, std::vector<std::string> names);
  int channel_count() const { return static_cast<int>(channels.size()); }
  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  float& at(int x, int y, int c) { return data[index(x, y, c)]; }
  float at(int x, int y, int c) const { return data[index(x, y, c)]; }
  std::size_t index(int x, int y, int c) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               channels.size() +
           static_cast<std::size_t>(c);
  }
  /// Index of a named channel, -1 if there is none.
  int channel(const std::string& name) const;
};

/// The image with the channels of others of the same size added, named as EXR layers: "variance.R".
Image with_layers(const Image& image, const std::map<std::string, Image>& layers);

/// Reads any image OpenImageIO reads, as float: the first part of the file, its data window.
/// Throws InputError on a missing or empty file, an unknown format, or a file that ends early.
/// Values are as stored: no colour transform (integers are divided by their largest value), no
/// multiplication by alpha.
Image read_image(const std::string& path);

/// Writes an EXR (32-bit float, ZIP, channel names kept) beside its place and renames it. Throws
/// InputError(path, "", "cannot be written: ..."). header: string attributes, e.g. {"opaline:technique",
/// "hierarchical"}.
void write_exr(const std::string& path, const Image& image, const std::map<std::string, std::string>& header = {});

/// Writes an 8-bit sRGB PNG of the R, G, B channels (without them, of the first channel as grey),
/// value * exposure clipped to [0, 1], NaN shown black, no dither; beside its place, then renamed.
/// Throws InputError as write_exr.
void write_png(const std::string& path, const Image& image, double exposure = 1);

/// Exposure that puts the 99th percentile of the largest RGB value at 0.9 (the peak, where fewer
/// than 1 % of the pixels are lit); 1 for a black image. Values that are not finite don't count.
double auto_exposure(const Image& image);

}  // namespace opaline
