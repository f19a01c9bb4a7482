// The truth behind the reference: light paths through the medium and its smooth boundary, without bias.
// path_traced.md has the derivation, the conventions and the limits.
#include "render/path_tracing/medium_walk.h"
#include "render/progress.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

namespace opaline {
namespace {

/// Mean and the variance of the mean, one sample after the other (Welford 1962).
class MeanOfSamples {
 public:
  void add(const Rgb& x) {
    ++count_;
    const Rgb d = x - mean_;
    mean_ += d / count_;
    squares_ += d * (x - mean_);
  }
  Rgb mean() const { return mean_; }
  Rgb variance() const { return squares_ / (count_ * (count_ - 1)); }

 private:
  double count_ = 0;
  Rgb mean_{0}, squares_{0};
};

Counters named(const PathCounts& c, std::uint64_t paths, std::uint64_t equal_channels) {
  Counters counters;
  counters.done = {{"paths", paths},
                   {"walks", c.walks},
                   {"scatterings", c.scatterings},
                   {"internal_reflections", c.reflections},
                   {"exits", c.exits},
                   {"roulette_ends", c.roulette_ends},
                   {"connections", c.connections},
                   {"boundary_rays", c.rays.boundary},
                   {"shadow_rays", c.rays.shadow},
                   {"facet_nodes", c.search.nodes},
                   {"facets_tested", c.search.facets},
                   {"light_chains", c.chain.chains},
                   {"light_chain_links", c.chain.links},
                   {"light_chain_trials", c.chain.trials}};
  counters.skipped = {{"equal_channel_walks", equal_channels},
                      {"faint_searches", c.searches_skipped},
                      {"walks_lost_at_edges", c.lost},
                      {"light_chains_given_up", c.chain.trials_given_up}};
  return counters;
}

class PreparedPathTraced : public PreparedTechnique {
 public:
  PreparedPathTraced(const SharedScene& shared, int paths)
      : lights_(shared.scene), seed_(shared.settings.irradiance.seed), paths_(paths) {
    media_.reserve(shared.scene.objects.size());
    for (std::size_t i = 0; i < shared.scene.objects.size(); ++i)
      media_.emplace_back(shared.scene, shared.rays, static_cast<int>(i), lights_);
  }

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.radiance.resize(view.points.size());
    std::vector<glm::vec3>& variance = frame.images["variance"];
    variance.resize(view.points.size());
    tbb::enumerable_thread_specific<PathCounts> per_thread;
    Progress progress(view.points.size());
    tbb::parallel_for(std::size_t{0}, view.points.size(), [&](std::size_t i) {
      const MeanOfSamples samples = sample(view.points[i], per_thread.local());
      frame.radiance[i] = glm::vec3(samples.mean());
      variance[i] = glm::vec3(samples.variance());
      progress.advance(1);
    });
    PathCounts counts;
    for (const PathCounts& c : per_thread) counts += c;
    frame.counters = named(counts, paths_of(view), equal_channel_walks(view));
    return frame;
  }

 private:
  const WalkMedium& medium(const VisiblePoint& p) const { return media_[static_cast<std::size_t>(p.object)]; }

  MeanOfSamples sample(const VisiblePoint& p, PathCounts& counts) const {
    MeanOfSamples samples;
    for (std::uint64_t path = 0; path < static_cast<std::uint64_t>(paths_); ++path) {
      RandomStream random{seed_, p.pixel, path};
      MediumWalk walk(medium(p), lights_, random, counts);
      Rgb sum(0);
      for (int lead = 0; lead < medium(p).channels.count; ++lead)
        sum += walk.radiance(glm::dvec3(p.position), p.triangle, glm::normalize(glm::dvec3(p.w_o)), lead);
      samples.add(sum);
    }
    return samples;
  }

  std::uint64_t paths_of(const GBuffer& view) const { return view.points.size() * static_cast<std::uint64_t>(paths_); }
  std::uint64_t equal_channel_walks(const GBuffer& view) const {
    std::uint64_t equal = 0;
    for (const VisiblePoint& p : view.points) equal += static_cast<std::uint64_t>(3 - medium(p).channels.count);
    return equal * static_cast<std::uint64_t>(paths_);
  }

  PathLights lights_;
  std::vector<WalkMedium> media_;
  std::uint64_t seed_;
  int paths_;
};

std::string not_applicable(const Scene& scene) {
  for (const Object& object : scene.objects) {
    const std::string fault = closed_mesh_fault(object.mesh);
    if (!fault.empty()) return fmt::format("object '{}': {}", object.name, fault);
  }
  return {};
}

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  return std::make_unique<PreparedPathTraced>(shared, static_cast<int>(settings.number("paths")));
}

}  // namespace

Technique path_traced_technique() {
  Technique technique{
      "path_traced",
      "transport itself: light paths with any phase g, no profile, no bias, with a variance image",
      "light paths: Veach 1997, \"Robust Monte Carlo Methods for Light Transport Simulation\"; refraction into "
      "facets: Walter, Zhao, Holzschuh, Bala 2009, \"Single Scattering in Refractive Media with Triangle Mesh "
      "Boundaries\"",
      {"cpu"},
      "closed meshes that don't overlap, seen and lit from outside; flat facets refract; as everywhere here no light "
      "reflected at the outside of a surface, and none that has left the medium and enters it again; light of "
      "point-like "
      "lights that is never scattered is not seen; noise falls with the square root of the paths",
      {{"paths", "64", "light paths per pixel and distinct colour channel", {}, 2, 1e6, true}},
      {.camera = false, .light = true, .material = true, .geometry = true},
      not_applicable,
      prepare};
  technique.needs_irradiance = false;
  technique.statistical = true;
  return technique;
}

}  // namespace opaline
