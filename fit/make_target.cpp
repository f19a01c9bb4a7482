#include "fit/solve.h"

#include "render/choices.h"
#include "render/input_error.h"

#include <fmt/format.h>

#include <cmath>

namespace opaline {
namespace {

using Eigen::Index;

/// Where R, G and B are, or the one channel of a grey picture.
std::vector<int> colour_channels(const Image& target) {
  if (target.channels.size() == 1) return {0};
  return {target.channel("R"), target.channel("G"), target.channel("B")};
}

Eigen::MatrixXd picture_rows(const TransportOperator& op, const Image& target, const std::string& name) {
  const std::vector<int> channels = colour_channels(target);
  Eigen::MatrixXd rows(static_cast<Index>(op.rows()), static_cast<Index>(channels.size()));
  for (std::size_t p = 0; p < op.rows(); ++p)
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const std::uint32_t pixel = op.pixels[p];
      const float value = target.data[pixel * target.channels.size() + static_cast<std::size_t>(channels[c])];
      if (!std::isfinite(value))
        throw InputError(name,
                         fmt::format("pixel ({}, {}) channel {}", pixel % static_cast<std::uint32_t>(op.width),
                                     pixel / static_cast<std::uint32_t>(op.width), "RGB"[c]),
                         "is not finite; leave such pixels out with a --mask image");
      rows(static_cast<Index>(p), static_cast<Index>(c)) = static_cast<double>(value);
    }
  return rows;
}

}  // namespace

void check_target(const Image& target, const Scene& scene, const std::string& name) {
  if (target.width != scene.film.width || target.height != scene.film.height)
    throw InputError(name, "",
                     fmt::format("is {} x {} pixels, but the scene's film is {} x {}", target.width, target.height,
                                 scene.film.width, scene.film.height));
  if (target.channels.size() == 1) return;
  for (const char* channel : {"R", "G", "B"})
    if (target.channel(channel) < 0)
      throw InputError(name, "",
                       "needs the channels R, G, B, or one channel alone; it has " + join_names(target.channels));
}

void replace_picture(FitTarget& target, Eigen::MatrixXd picture) {
  target.picture = std::move(picture);
  target.channels = static_cast<int>(target.picture.cols());
  for (int c = 0; c < target.channels; ++c) {
    target.y[static_cast<std::size_t>(c)] = basis_sum(target.q(c), target.picture.col(c));
    for (int d = 0; d < target.channels; ++d) target.products(c, d) = target.picture.col(c).dot(target.picture.col(d));
  }
}

FitTarget make_target(TransportOperator op, const Image& target, const std::string& name, const NoiseModel& noise) {
  if (op.pixels.empty()) throw InputError(name, "", "no pixel takes part: the object is out of view or masked");
  Eigen::MatrixXd picture = picture_rows(op, target, name);
  if (picture.squaredNorm() == 0)
    throw InputError(name, "", "is black on every fitted pixel; the scene says that the object is seen there");
  OrthonormalOperator basis = orthonormalise(op);
  op.values = {};
  FitTarget result{std::move(op), std::move(basis)};
  result.noise = noise;
  replace_picture(result, std::move(picture));
  return result;
}

}  // namespace opaline
