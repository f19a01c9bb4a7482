#include "fit/fit_job.h"
#include "fit/reduced_picture.h"
#include "render/irradiance/profile_gather.h"
#include "render/techniques/technique.h"

#include <unordered_map>

namespace opaline {
namespace {

/// The view restricted to `pixels` of the operator's rows, evenly spread.
GBuffer some_points(const GBuffer& view, const TransportOperator& op, std::size_t pixels) {
  GBuffer some{view.width, view.height, {}, {}};
  std::unordered_map<std::uint32_t, const VisiblePoint*> by_pixel;
  for (const VisiblePoint& p : view.points) by_pixel.emplace(p.pixel, &p);
  const std::size_t count = std::min(pixels, op.rows());
  for (std::size_t i = 0; i < count; ++i) some.points.push_back(*by_pixel.at(op.pixels[i * op.rows() / count]));
  return some;
}

/// `expanded` against a fresh gather at some of the operator's pixels.
OperatorError error_of(const Scene& scene, const TransportOperator& op, const Image& expanded,
                       const OperatorSettings& settings, const ProfileInfo& profile, const Material& material,
                       int material_index, std::size_t pixels) {
  Scene with = scene;
  with.materials[static_cast<std::size_t>(material_index)] = material;
  SharedScene shared(with, {settings.samples, settings.irradiance});
  shared.view = some_points(shared.view, op, pixels);
  const Technique& reference = find_technique("hierarchical");
  const Settings tight(
      reference.settings,
      {{"max_relative_error", "3e-4"}, {"criterion", "bound"}, {"discretisation", "fixed"}, {"profile", profile.name}});
  const Frame frame = reference.prepare(shared, tight)->render(shared.view);
  const Image gathered = shade(with, shared.view, frame, op.lobe);
  const Image bound = shade_layers(with, shared.view, frame, op.lobe).at("bound");
  double error = 0, at_most = 0, norm = 0;
  for (const VisiblePoint& p : shared.view.points)
    for (std::size_t c = 0; c < 3; ++c) {
      const double a = static_cast<double>(gathered.data[p.pixel * 4u + c]),
                   b = static_cast<double>(expanded.data[p.pixel * 4u + c]),
                   known = static_cast<double>(bound.data[p.pixel * bound.channels.size() + c]);
      error += (a - b) * (a - b);
      at_most += (std::abs(a - b) + known) * (std::abs(a - b) + known);
      norm += a * a;
    }
  if (norm <= 0) return {};
  return {std::sqrt(error / norm), std::sqrt(at_most / norm)};
}

}  // namespace

OperatorError operator_error(const Scene& scene, const TransportOperator& op, const OperatorSettings& settings,
                             const ProfileInfo& profile, const Material& material, int material_index,
                             std::size_t pixels) {
  return error_of(scene, op, operator_image(op, profile, material), settings, profile, material, material_index,
                  pixels);
}

OperatorError operator_error(const Scene& scene, const FitTarget& target, const OperatorSettings& settings,
                             const ProfileInfo& profile, const Material& material, int material_index,
                             std::size_t pixels) {
  return error_of(scene, target.op, target_image(target, profile, material), settings, profile, material,
                  material_index, pixels);
}

}  // namespace opaline
