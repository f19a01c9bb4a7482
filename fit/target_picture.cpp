#include "fit/target_picture.h"

#include "fit/noise_estimate.h"
#include "fit/solve.h"
#include "fit/transfer_curve.h"
#include "render/input_error.h"
#include "render/visibility/gbuffer.h"

#include <fmt/format.h>

#include <cmath>

namespace opaline {
namespace {

std::vector<float> read_mask(const std::string& path, const Scene& scene) {
  const Image image = read_image(path);
  if (image.width != scene.film.width || image.height != scene.film.height)
    throw InputError(path, "",
                     fmt::format("the mask is {} x {} pixels, but the scene's film is {} x {}", image.width,
                                 image.height, scene.film.width, scene.film.height));
  std::vector<float> mask(image.pixel_count());
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = image.data[i * image.channels.size()];
  return mask;
}

TransferCurve curve_of(const std::string& path, const TargetOptions& options) {
  if (!options.transfer.empty()) return TransferCurve::parse(options.transfer);
  if (!linear_by_convention(path))
    throw InputError(
        path, "",
        "does not hold linear light by convention: say what it holds with --transfer linear, srgb, rec709, "
        "gamma:G or FILE.csv");
  return {};
}

std::vector<int> colours(const Image& image) {
  if (image.channels.size() == 1) return {0};
  return {image.channel("R"), image.channel("G"), image.channel("B")};
}

/// Stored values at or above the limit in any colour: the pixel is not usable.
void drop_saturated(const Image& stored, double limit, TargetPicture& out) {
  if (!std::isfinite(limit)) return;  // infinite values are an error then, not saturated
  for (std::size_t p = 0; p < stored.pixel_count(); ++p) {
    bool full = false;
    for (const int c : colours(stored))
      full |= static_cast<double>(stored.data[p * stored.channels.size() + static_cast<std::size_t>(c)]) >= limit;
    if (!full || !(out.usable[p] > 0)) continue;
    out.usable[p] = 0;
    ++out.saturated;
  }
}

Image to_linear(const Image& stored, const TransferCurve& curve, double exposure) {
  const std::vector<int> from = colours(stored);
  Image linear(stored.width, stored.height,
               from.size() == 3 ? std::vector<std::string>{"R", "G", "B"} : std::vector<std::string>{"Y"});
  for (std::size_t p = 0; p < stored.pixel_count(); ++p)
    for (std::size_t c = 0; c < from.size(); ++c)
      linear.data[p * from.size() + c] =
          curve.name() == "linear" && exposure == 1
              ? stored.data[p * stored.channels.size() + static_cast<std::size_t>(from[c])]
              : static_cast<float>(curve.to_linear(static_cast<double>(
                                       stored.data[p * stored.channels.size() + static_cast<std::size_t>(from[c])])) /
                                   exposure);
  return linear;
}

Image average(const Image& a, const Image& b) {
  Image mean = a;
  for (std::size_t i = 0; i < mean.data.size(); ++i) mean.data[i] = 0.5f * (a.data[i] + b.data[i]);
  return mean;
}

/// The noise of the average of two captures.
NoiseModel halved(NoiseModel noise) {
  for (double& sd : noise.read_sd) sd /= std::sqrt(2.0);
  for (double& shot : noise.shot) shot /= 2;
  for (double& sd : noise.relative) sd /= std::sqrt(2.0);
  return noise;
}

/// A layer's variances in the linear picture's units.
Image scaled_layers(Image stored, double exposure) {
  for (float& v : stored.data) v = static_cast<float>(static_cast<double>(v) / (exposure * exposure));
  return stored;
}

NoiseModel noise_of(const TargetOptions& options, const Image& stored, const TargetPicture& picture,
                    const TransferCurve& curve) {
  if (options.noise == "flat") return noise_from_flat(picture.linear, picture.usable);
  if (options.noise == "layer" && curve.name() == "linear")
    return noise_from_layer(picture.linear, scaled_layers(stored, options.exposure), picture.usable);
  if (options.noise == "layer")
    throw InputError("--noise", "", "'layer' needs a picture that is linear, but --transfer says " + curve.name());
  return parse_noise(options.noise);
}

void check_options(const TargetOptions& options) {
  if (!(options.exposure > 0) || !std::isfinite(options.exposure))
    throw InputError("--exposure", "", fmt::format("{} is not a number above 0", options.exposure));
  if (options.noise != "flat" && options.noise != "layer") parse_noise(options.noise);
}

/// Angle between the mirror direction of the view and the way to a light, over the light's own radius [rad].
double mirror_angle(const VisiblePoint& p, const Light& light) {
  const glm::dvec3 n(p.normal), w(p.w_o), at(p.position);
  const glm::dvec3 mirror = glm::normalize(2 * glm::dot(n, w) * n - w);
  const auto angle = [&](const glm::dvec3& to_light) {
    return std::acos(std::clamp(glm::dot(mirror, glm::normalize(to_light)), -1.0, 1.0));
  };
  if (const auto* sun = std::get_if<DirectionalLight>(&light))
    return angle(-sun->direction) - glm::radians(sun->angular_radius_deg);
  if (const auto* lamp = std::get_if<PointLight>(&light)) return angle(lamp->position - at);
  if (const auto* projector = std::get_if<ProjectorLight>(&light)) return angle(projector->position - at);
  return pi;
}

}  // namespace

std::vector<float> away_from_highlights(const Scene& scene, double degrees) {
  std::vector<float> away(static_cast<std::size_t>(scene.film.width) * static_cast<std::size_t>(scene.film.height), 1);
  const RayScene rays(scene);
  for (const VisiblePoint& p : make_gbuffer(scene, rays).points)
    for (const Light& light : scene.lights)
      if (mirror_angle(p, light) < glm::radians(degrees)) away[p.pixel] = 0;
  return away;
}

TargetPicture read_target(const std::string& path, const Scene& scene, const TargetOptions& options) {
  check_options(options);
  const TransferCurve curve = curve_of(path, options);
  const Image stored = read_image(path);
  check_target(stored, scene, path);
  TargetPicture out;
  out.usable.assign(stored.pixel_count(), 1.0f);
  if (!options.mask.empty()) out.usable = read_mask(options.mask, scene);
  for (const float u : out.usable) out.masked += !(u > 0);
  const double limit = options.saturation.value_or(linear_by_convention(path) ? HUGE_VAL : 0.999);
  drop_saturated(stored, limit, out);
  if (options.exclude_specular_deg > 0) {
    const std::vector<float> away = away_from_highlights(scene, options.exclude_specular_deg);
    for (std::size_t p = 0; p < away.size(); ++p) {
      if (away[p] > 0 || !(out.usable[p] > 0)) continue;
      out.usable[p] = 0;
      ++out.near_highlights;
    }
  }
  out.linear = to_linear(stored, curve, options.exposure);
  if (options.repeat.empty()) {
    out.noise = noise_of(options, stored, out, curve);
    return out;
  }
  const Image second = read_image(options.repeat);
  check_target(second, scene, options.repeat);
  if (second.channels.size() == 1 && out.linear.channels.size() != 1)
    throw InputError(options.repeat, "", "is grey, but " + path + " is not");
  drop_saturated(second, limit, out);
  const Image other = to_linear(second, curve, options.exposure);
  out.noise = halved(noise_from_repeat(out.linear, other, out.usable));
  out.linear = average(out.linear, other);
  return out;
}

}  // namespace opaline
