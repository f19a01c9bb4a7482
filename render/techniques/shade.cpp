#include "model/check.h"
#include "model/fresnel.h"
#include "render/techniques/technique.h"

namespace opaline {

Image shade(const Scene& scene, const GBuffer& view, const std::vector<glm::vec3>& exitance, ExitLobe lobe) {
  OPALINE_CHECK(exitance.size() == view.points.size());
  Image image(view.width, view.height, {"R", "G", "B", "A"});
  std::vector<double> scale;  // 1 / (pi c) per object
  for (const Object& object : scene.objects)
    scale.push_back(
        1 / (pi * exit_lobe_normalisation(scene.materials[static_cast<std::size_t>(object.material)].eta, lobe)));
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const VisiblePoint& p = view.points[i];
    const auto object = static_cast<std::size_t>(p.object);
    const double eta = scene.materials[static_cast<std::size_t>(scene.objects[object].material)].eta;
    const double lobe_value = fresnel_transmittance(static_cast<double>(p.cos_o), eta) * scale[object];
    float* pixel = &image.data[static_cast<std::size_t>(p.pixel) * 4];
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(lobe_value * static_cast<double>(exitance[i][c]));
    pixel[3] = 1;
  }
  return image;
}

}  // namespace opaline
