#include "render/image_space/image_space.h"

#include "render/image_space/sample_gather.h"
#include "render/image_space/shadow_edges.h"
#include "render/input_error.h"
#include "render/techniques/gather_technique.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <mutex>

namespace opaline {
namespace {

using Uniform = ImageSpaceSettings::Uniform;

/// The points of one object, summed in parallel.
class ObjectGather {
 public:
  ObjectGather(const ImageSpaceObject& object, const ImageSpaceSettings& settings, const GBuffer& view,
               const ViewIrradiance& irradiance, std::vector<IrradianceMap> maps)
      : object_(object),
        settings_(settings),
        view_(view),
        irradiance_(irradiance),
        maps_(std::move(maps)),
        combined_(combined_points(object, settings, view, irradiance)) {}

  void run(const std::vector<std::uint32_t>& indices, Frame& frame) {
    std::mutex mutex;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, indices.size(), 256), [&](const auto& range) {
      GatherResult counts;
      std::uint64_t with_uniform = 0;
      for (std::size_t k = range.begin(); k != range.end(); ++k) {
        const std::uint32_t i = indices[k];
        with_uniform += combined_[i];
        frame.exitance[i] = exitance(view_.points[i], combined_[i] ? object_.combined : object_.importance, counts);
      }
      const std::scoped_lock lock(mutex);
      add_counts(counts, range.size(), with_uniform, frame.counters);
    });
  }

 private:
  glm::vec3 exitance(const VisiblePoint& p, const SampleSets& sets, GatherResult& counts) const {
    const SampleSet& set =
        sets.of_pixel(static_cast<int>(p.pixel) % view_.width, static_cast<int>(p.pixel) / view_.width);
    GatherResult result;
    gather_samples({maps_, object_.profiles.sum(), sets.density, settings_.jacobian, settings_.only_valid,
                    static_cast<float>(settings_.min_plane_cosine)},
                   set, p.position, p.normal, result);
    counts.met += result.met, counts.lit += result.lit, counts.looked_up += result.looked_up;
    return exitance_of(object_, settings_, irradiance_, result.sums, result.valid);
  }

  void add_counts(const GatherResult& counts, std::size_t points, std::uint64_t with_uniform,
                  Counters& counters) const {
    std::uint64_t views = 0;
    for (const IrradianceMap& map : maps_) views += map.lit;
    const std::uint64_t samples = points * views * static_cast<std::uint64_t>(settings_.samples);
    counters.done["samples"] += samples;
    counters.done["samples_looked_up"] += counts.looked_up;
    counters.done["points_with_uniform_set"] += with_uniform;
    counters.skipped["samples_off_object"] += samples - counts.met;
    counters.skipped["samples_unlit"] += counts.met - counts.lit;
    counters.skipped["uniform_sets_far_from_shadow_edges"] += points - with_uniform;
  }

  const ImageSpaceObject& object_;
  const ImageSpaceSettings& settings_;
  const GBuffer& view_;
  const ViewIrradiance& irradiance_;
  std::vector<IrradianceMap> maps_;
  std::vector<std::uint8_t> combined_;
};

int whole_number(const Settings& settings, const std::string& key) {
  const double value = settings.number(key);
  if (value != std::floor(value))
    throw InputError("--set " + key, "", "'" + settings.word(key) + "' is not a whole number");
  return static_cast<int>(value);
}

}  // namespace

glm::vec3 exitance_of(const ImageSpaceObject& object, const ImageSpaceSettings& settings,
                      const ViewIrradiance& irradiance, const float* sums, const float* valid) {
  glm::vec3 b;
  for (int c = 0; c < 3; ++c) {
    const int table = object.profiles.sum().table_of[c];
    b[c] = sums[irradiance.channels == 1 ? table : c] * static_cast<float>(irradiance.colour[c]);
    if (settings.only_valid && valid[table] > 0)
      b[c] *= static_cast<float>(object.profiles.profile(c).total()) / valid[table];
  }
  return b;
}

std::vector<std::uint8_t> combined_points(const ImageSpaceObject& object, const ImageSpaceSettings& settings,
                                          const GBuffer& view, const ViewIrradiance& irradiance) {
  if (settings.uniform == Uniform::near_edges) return near_light_edges(view, irradiance, object.disc_radius);
  return std::vector<std::uint8_t>(view.points.size(), settings.uniform == Uniform::always);
}

std::vector<SettingSpec> image_space_setting_specs() {
  return {
      profile_setting(),
      {"samples_per_pixel", "64", "N, in each view, a whole number", {}, 8, 1024},
      {"pattern", "4", "side of the interleaved pattern of sample sets, a whole number; 1: one set", {}, 1, 16},
      {"views", "camera", "irradiance images: the camera's, or also one from each light", {"camera", "camera+light"}},
      {"irradiance",
       "traced",
       "by shadow rays, or (gpu, lights without extent) by shadow maps",
       {"traced", "shadow_maps"}},
      {"shadow_map_pixels", "2048", "side of each shadow map", {}, 16, 16384},
      {"light_view_pixels", "512", "side of the lights' images, which show all of the scene", {}, 16, 4096},
      {"jacobian", "on", "off: areas on the tangent plane stand for those of the surface (the paper)", {"on", "off"}},
      {"normalise",
       "all",
       "by all samples, or by those that meet the object (the paper; views=camera only)",
       {"all", "valid"}},
      {"uniform",
       "near_edges",
       "where a part of the samples is uniform on a disc: near edges of light on the film",
       {"near_edges", "always", "never"}},
      {"uniform_share", "0.25", "the part of the samples that is uniform there", {}, 0.05, 0.9},
      {"min_plane_cosine",
       "0.8",
       "the plane of the samples is turned to the viewer up to this cosine; 0: the tangent plane (the paper)",
       {},
       0,
       1},
      {"disc_flux", "0.95", "part of the profile's flux that falls inside the disc", {}, 0.5, 0.999}};
}

ImageSpaceSettings read_image_space_settings(const Settings& settings) {
  ImageSpaceSettings s;
  s.profile = settings.word("profile");
  s.samples = whole_number(settings, "samples_per_pixel");
  s.pattern = whole_number(settings, "pattern");
  s.light_views = settings.word("views") == "camera+light";
  s.light_view_pixels = whole_number(settings, "light_view_pixels");
  s.shadow_maps = settings.word("irradiance") == "shadow_maps";
  s.shadow_map_pixels = whole_number(settings, "shadow_map_pixels");
  s.jacobian = settings.word("jacobian") == "on";
  s.only_valid = settings.word("normalise") == "valid";
  s.uniform = settings.word("uniform") == "always"  ? Uniform::always
              : settings.word("uniform") == "never" ? Uniform::never
                                                    : Uniform::near_edges;
  s.uniform_share = settings.number("uniform_share");
  s.disc_flux = settings.number("disc_flux");
  s.min_plane_cosine = settings.number("min_plane_cosine");
  if (s.only_valid && s.light_views)
    throw InputError("--set normalise", "",
                     "'valid' counts the samples of one view; give views=camera or normalise=all");
  return s;
}

std::vector<ImageSpaceObject> image_space_objects(const Scene& scene, const ImageSpaceSettings& settings,
                                                  std::uint64_t seed) {
  std::vector<ImageSpaceObject> objects;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Object& object = scene.objects[i];
    const double r_max = 1.01 * diameter(object.mesh);
    ImageSpaceObject o{ChannelProfiles(*find_profile(settings.profile),
                                       scene.materials[static_cast<std::size_t>(object.material)], r_max),
                       {},
                       {},
                       0};
    o.disc_radius = disc_radius(o.profiles, settings.disc_flux, r_max);
    SampleSettings set{settings.samples, settings.pattern, 0, o.disc_radius, seed + 0x51ed270b * i};
    if (settings.uniform != Uniform::always) o.importance = make_sample_sets(o.profiles, set);
    set.uniform_share = settings.uniform_share;
    if (settings.uniform != Uniform::never) o.combined = make_sample_sets(o.profiles, set);
    objects.push_back(std::move(o));
  }
  return objects;
}

Frame gather_image_space(const Scene& scene, const std::vector<ImageSpaceObject>& objects,
                         const ImageSpaceSettings& settings, const GBuffer& view, const ViewIrradiance& irradiance,
                         const std::vector<LitView>& others) {
  Frame frame;
  frame.exitance.assign(view.points.size(), glm::vec3(0));
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::vector<std::uint32_t> indices = points_of_object(view, static_cast<int>(i)).indices;
    if (indices.empty()) continue;
    std::vector<IrradianceMap> maps = {
        make_irradiance_map(scene, view, irradiance, static_cast<int>(i), settings.jacobian)};
    for (const LitView& other : others)
      maps.push_back(make_irradiance_map(scene, other.view, other.irradiance, static_cast<int>(i), settings.jacobian));
    ObjectGather(objects[i], settings, view, irradiance, std::move(maps)).run(indices, frame);
    frame.counters.done["channels"] += static_cast<std::uint64_t>(objects[i].profiles.distinct());
    frame.counters.skipped["equal_channels"] += 3 - static_cast<std::uint64_t>(objects[i].profiles.distinct());
    frame.counters.skipped["samples_without_weight"] +=
        objects[i].importance.without_weight + objects[i].combined.without_weight;
  }
  return frame;
}

}  // namespace opaline
