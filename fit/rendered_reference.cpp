#include "fit/rendered_reference.h"

#include "fit/noise_estimate.h"
#include "render/input_error.h"

namespace opaline {
namespace {

RenderResult render_with(const TargetScene& from, const Material& material, const RenderOptions& options) {
  Scene scene = *from.scene;
  scene.materials[static_cast<std::size_t>(from.material)] = material;
  return render_scene(scene, options);
}

NoiseModel noise_of(const RenderResult& made, const FitTarget& target) {
  const auto layer = made.layers.find("variance");
  if (layer == made.layers.end()) return {};
  Image named = layer->second;
  for (std::size_t c = 0; c < 3; ++c) named.channels[c] = "variance." + named.channels[c];
  std::vector<float> usable(made.image.pixel_count());
  for (const std::uint32_t pixel : target.op.pixels) usable[pixel] = 1;
  return noise_from_layer(made.image, named, usable);
}

ReferencePicture rows_of(const RenderResult& made, const FitTarget& target) {
  ReferencePicture out;
  out.rows.resize(static_cast<Eigen::Index>(target.rows()), target.channels);
  for (std::size_t p = 0; p < target.rows(); ++p)
    for (int c = 0; c < target.channels; ++c)
      out.rows(static_cast<Eigen::Index>(p), c) =
          static_cast<double>(made.image.data[target.op.pixels[p] * 4u + static_cast<std::size_t>(c)]);
  out.noise = noise_of(made, target);
  return out;
}

}  // namespace

void check_reference(const RenderOptions& options, const std::vector<TargetScene>& scenes) {
  check_render_options(options);
  const Technique& technique = find_technique(options.technique);
  for (const TargetScene& one : scenes)
    if (const std::string reason = why_not_applicable(technique, *one.scene); !reason.empty())
      throw InputError(one.scene->path, "", technique.name + " cannot render it: " + reason);
}

Reference rendered_reference(const std::vector<TargetScene>& scenes, const std::vector<FitTarget>& targets,
                             const Material& base, const FreeParameters& free, RenderOptions options) {
  if (find_technique(options.technique).statistical) options.shared.irradiance.seed += 7919;
  return [&scenes, &targets, &base, free, options](const ParameterVector& at) {
    const Material material = to_material(at, base, free);
    std::vector<ReferencePicture> out;
    std::optional<RenderResult> made;
    for (std::size_t t = 0; t < targets.size(); ++t) {
      if (t == 0 || scenes[t].scene != scenes[t - 1].scene) made = render_with(scenes[t], material, options);
      out.push_back(rows_of(*made, targets[t]));
    }
    return out;
  };
}

}  // namespace opaline
