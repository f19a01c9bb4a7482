#include "model/check.h"
#include "model/fresnel.h"
#include "render/techniques/technique.h"

namespace opaline {
namespace {

/// Factor from exitance to radiance at each visible point.
std::vector<double> exit_lobes(const Scene& scene, const GBuffer& view, ExitLobe lobe) {
  std::vector<double> scale;  // 1 / (pi c) per object
  for (const Object& object : scene.objects)
    scale.push_back(
        1 / (pi * exit_lobe_normalisation(scene.materials[static_cast<std::size_t>(object.material)].eta, lobe)));
  std::vector<double> lobes;
  lobes.reserve(view.points.size());
  for (const VisiblePoint& p : view.points) {
    const auto object = static_cast<std::size_t>(p.object);
    const double eta = scene.materials[static_cast<std::size_t>(scene.objects[object].material)].eta;
    lobes.push_back(fresnel_transmittance(static_cast<double>(p.cos_o), eta) * scale[object]);
  }
  return lobes;
}

/// Values of the visible points, each times its factor, at their pixels.
Image scatter(const GBuffer& view, const std::vector<glm::vec3>& values, const std::vector<double>& factors,
              std::vector<std::string> channels) {
  OPALINE_CHECK(values.size() == view.points.size());
  Image image(view.width, view.height, std::move(channels));
  const int alpha = image.channel("A");
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    float* pixel = &image.data[static_cast<std::size_t>(view.points[i].pixel) * image.channels.size()];
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(factors[i] * static_cast<double>(values[i][c]));
    if (alpha >= 0) pixel[alpha] = 1;
  }
  return image;
}

/// Factors from what the frame holds to radiance.
std::vector<double> frame_factors(const Scene& scene, const GBuffer& view, const Frame& frame, ExitLobe lobe) {
  OPALINE_CHECK(frame.exitance.empty() || frame.radiance.empty());
  if (frame.radiance.empty()) return exit_lobes(scene, view, lobe);
  return std::vector<double>(view.points.size(), 1.0);
}

}  // namespace

Image shade(const Scene& scene, const GBuffer& view, const std::vector<glm::vec3>& exitance, ExitLobe lobe) {
  return scatter(view, exitance, exit_lobes(scene, view, lobe), {"R", "G", "B", "A"});
}

Image shade(const Scene& scene, const GBuffer& view, const Frame& frame, ExitLobe lobe) {
  return scatter(view, frame.radiance.empty() ? frame.exitance : frame.radiance,
                 frame_factors(scene, view, frame, lobe), {"R", "G", "B", "A"});
}

std::map<std::string, Image> shade_layers(const Scene& scene, const GBuffer& view, const Frame& frame, ExitLobe lobe) {
  std::map<std::string, Image> layers;
  if (frame.images.empty()) return layers;
  const std::vector<double> factors = frame_factors(scene, view, frame, lobe);
  for (const auto& [name, values] : frame.images) layers[name] = scatter(view, values, factors, {"R", "G", "B"});
  return layers;
}

}  // namespace opaline
