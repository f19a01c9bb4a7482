#include "render/image_space/image_space.h"

#include "render/image_space/sample_gather.h"
#include "render/image_space/shadow_edges.h"
#include "render/input_error.h"
#include "render/scene/texture_coordinates.h"
#include "render/techniques/gather_technique.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <mutex>

namespace opaline {
namespace {

using Uniform = ImageSpaceSettings::Uniform;

/// The profiles of one point of a textured object.
class OwnProfiles {
 public:
  OwnProfiles(const ProfileInfo& info, const Material& here) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Medium<double> medium = here.channel(static_cast<int>(c));
      for (std::size_t b = 0; b < c && !use[c]; ++b)
        if (here.sigma_a[static_cast<int>(b)] == medium.sigma_a &&
            here.sigma_s_prime[static_cast<int>(b)] == medium.sigma_s_prime)
          use[c] = use[b];
      if (use[c]) continue;
      made_[c] = info.make(medium);
      use[c] = made_[c].get();
    }
  }
  const Profile* use[3] = {};

 private:
  std::unique_ptr<Profile> made_[3];
};

/// The points of one object, summed in parallel.
class ObjectGather {
 public:
  ObjectGather(const Object& mesh, const Material& material, const ImageSpaceObject& object,
               const ImageSpaceSettings& settings, const GBuffer& view, const ViewIrradiance& irradiance,
               std::vector<IrradianceMap> maps)
      : mesh_(mesh.mesh),
        material_(material),
        profile_(*find_profile(settings.profile)),
        object_(object),
        settings_(settings),
        view_(view),
        irradiance_(irradiance),
        maps_(std::move(maps)),
        combined_(combined_points(object, settings, view, irradiance)) {}

  void run(const std::vector<std::uint32_t>& indices, Frame& frame) {
    std::mutex mutex;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, indices.size(), 256), [&](const auto& range) {
      PointCounts counts;
      for (std::size_t k = range.begin(); k != range.end(); ++k)
        frame.exitance[indices[k]] = exitance(view_.points[indices[k]], combined_[indices[k]], counts);
      const std::scoped_lock lock(mutex);
      add_counts(counts, range.size(), frame.counters);
    });
  }

 private:
  struct PointCounts {
    GatherResult samples;
    std::uint64_t with_uniform = 0, own_profiles = 0;
  };

  glm::vec3 exitance(const VisiblePoint& p, bool combined, PointCounts& counts) const {
    counts.with_uniform += combined;
    if (!object_.textured) return exitance(p, combined, object_.materials[0], nullptr, counts);
    const Material here = material_.at(uv_at(mesh_, p.triangle, p.position));
    const SampledMaterial& nearest = object_.materials[nearest_material(object_.materials, here)];
    if (here.sigma_a == nearest.material.sigma_a && here.sigma_s_prime == nearest.material.sigma_s_prime)
      return exitance(p, combined, nearest, nullptr, counts);
    ++counts.own_profiles;
    const OwnProfiles own(profile_, here);
    return exitance(p, combined, nearest, own.use, counts);
  }

  /// own: profiles in place of those that the sets follow, or null.
  glm::vec3 exitance(const VisiblePoint& p, bool combined, const SampledMaterial& material, const Profile* const* own,
                     PointCounts& counts) const {
    const SampleSets& sets = combined ? material.combined : material.importance;
    const SampleSet& set =
        sets.of_pixel(static_cast<int>(p.pixel) % view_.width, static_cast<int>(p.pixel) / view_.width);
    GatherResult result;
    SampleGather gather{maps_,
                        material.profiles.sum(),
                        sets.density,
                        settings_.jacobian,
                        settings_.only_valid,
                        static_cast<float>(settings_.min_plane_cosine)};
    if (own) std::copy_n(own, 3, gather.own);
    gather_samples(gather, set, p.position, p.normal, result);
    GatherResult& all = counts.samples;
    all.met += result.met, all.lit += result.lit, all.looked_up += result.looked_up;
    return exitance_of(material, settings_, irradiance_, result.sums, result.valid);
  }

  void add_counts(const PointCounts& all, std::size_t points, Counters& counters) const {
    const GatherResult& counts = all.samples;
    std::uint64_t views = 0;
    for (const IrradianceMap& map : maps_) views += map.lit;
    const std::uint64_t samples = points * views * static_cast<std::uint64_t>(settings_.samples);
    counters.done["samples"] += samples;
    counters.done["samples_looked_up"] += counts.looked_up;
    counters.done["points_with_uniform_set"] += all.with_uniform;
    if (object_.textured) {
      counters.done["points_with_own_profile"] += all.own_profiles;
      counters.skipped["own_profiles_of_representatives"] += points - all.own_profiles;
    }
    counters.skipped["samples_off_object"] += samples - counts.met;
    counters.skipped["samples_unlit"] += counts.met - counts.lit;
    counters.skipped["uniform_sets_far_from_shadow_edges"] += points - all.with_uniform;
  }

  const Mesh& mesh_;
  const Material& material_;
  const ProfileInfo& profile_;
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

void count_object(const ImageSpaceObject& object, Counters& counters) {
  // Where every point has its own profile, channels are never known to be equal beforehand.
  const int channels = object.textured ? 3 : object.materials[0].profiles.distinct();
  counters.done["channels"] += static_cast<std::uint64_t>(channels);
  counters.skipped["equal_channels"] += static_cast<std::uint64_t>(3 - channels);
  if (object.textured) counters.done["representative_materials"] += object.materials.size();
  for (const SampledMaterial& m : object.materials)
    counters.skipped["samples_without_weight"] += m.importance.without_weight + m.combined.without_weight;
}

ViewIrradiance in_colour(const ViewIrradiance& irradiance) {
  if (irradiance.channels == 3) return irradiance;
  ViewIrradiance out{3, Rgb(1), {}};
  out.values.reserve(3 * irradiance.values.size());
  for (const float e : irradiance.values)
    for (int c = 0; c < 3; ++c) out.values.push_back(e * static_cast<float>(irradiance.colour[c]));
  return out;
}

glm::vec3 exitance_of(const SampledMaterial& material, const ImageSpaceSettings& settings,
                      const ViewIrradiance& irradiance, const float* sums, const float* valid) {
  glm::vec3 b;
  for (int c = 0; c < 3; ++c) {
    const int table = material.profiles.sum().table_of[c];
    b[c] = sums[irradiance.channels == 1 ? table : c] * static_cast<float>(irradiance.colour[c]);
    if (settings.only_valid && valid[table] > 0)
      b[c] *= static_cast<float>(material.profiles.profile(c).total()) / valid[table];
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
    const Material& material = scene.materials[static_cast<std::size_t>(object.material)];
    const double r_max = 1.01 * diameter(object.mesh);
    ImageSpaceObject o;
    o.textured = material.textured();
    for (const Material& one : representative_materials(object, material)) {
      SampledMaterial sampled{one, ChannelProfiles(*find_profile(settings.profile), one, r_max), {}, {}};
      const double disc = disc_radius(sampled.profiles, settings.disc_flux, r_max);
      SampleSettings set{settings.samples, settings.pattern, 0, disc, seed + 0x51ed270b * i};
      if (settings.uniform != Uniform::always) sampled.importance = make_sample_sets(sampled.profiles, set);
      set.uniform_share = settings.uniform_share;
      if (settings.uniform != Uniform::never) sampled.combined = make_sample_sets(sampled.profiles, set);
      o.disc_radius = std::max(o.disc_radius, disc);
      o.materials.push_back(std::move(sampled));
    }
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
    const Object& object = scene.objects[i];
    const auto light = [&](const ViewIrradiance& e) { return objects[i].textured ? in_colour(e) : e; };
    const ViewIrradiance own = light(irradiance);
    std::vector<IrradianceMap> maps = {make_irradiance_map(scene, view, own, static_cast<int>(i), settings.jacobian)};
    for (const LitView& other : others)
      maps.push_back(
          make_irradiance_map(scene, other.view, light(other.irradiance), static_cast<int>(i), settings.jacobian));
    ObjectGather(object, scene.materials[static_cast<std::size_t>(object.material)], objects[i], settings, view, own,
                 std::move(maps))
        .run(indices, frame);
    count_object(objects[i], frame.counters);
  }
  return frame;
}

}  // namespace opaline
