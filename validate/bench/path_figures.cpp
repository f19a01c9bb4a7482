// What transport costs: light paths a second on a sphere and on the bench's object.
#include "datasets_synthetic/shapes/shapes.h"
#include "render/stopwatch.h"
#include "render/techniques/technique.h"
#include "validate/bench/figures.h"

#include <fmt/format.h>

#include <cmath>

namespace opaline::bench {
namespace {

void add_figures(const std::string& name, const Scene& scene, std::vector<Figure>& figures) {
  const SharedScene shared(scene, {}, false);
  const Technique& technique = find_technique("path_traced");
  const auto prepared = technique.prepare(shared, Settings(technique.settings, {{"paths", "4"}}));
  Stopwatch watch;
  const Frame frame = prepared->render(shared.view);
  const double seconds = watch.lap();
  const auto count = [&](const char* key) { return static_cast<double>(frame.counters.done.at(key)); };
  double radiance = 0, variance = 0;
  for (std::size_t i = 0; i < frame.radiance.size(); ++i) {
    radiance += static_cast<double>(frame.radiance[i].g) / static_cast<double>(frame.radiance.size());
    variance += static_cast<double>(frame.images.at("variance")[i].g) / static_cast<double>(frame.radiance.size());
  }
  figures.push_back({name + ": light paths (R, G, B)", count("paths") / seconds, 0, false, "1/s",
                     fmt::format("{:.1f} scatterings a path", count("scatterings") / count("paths"))});
  figures.push_back({"  scatterings", count("scatterings") / seconds, 0, false, "1/s",
                     fmt::format("{:.0f} tree nodes, {:.1f} rays each", count("facet_nodes") / count("scatterings"),
                                 (count("boundary_rays") + count("shadow_rays")) / count("scatterings"))});
  // The noise of one path: that of n is this over sqrt(n).
  figures.push_back(
      {"  relative noise of a pixel after one path", std::sqrt(4 * variance) / radiance, 0, true, "", ""});
}

}  // namespace

std::vector<Figure> path_figures(const SceneChoice& choice) {
  SceneChoice small = choice;
  small.film = 64;
  Scene scene = bench_scene(small);
  std::vector<Figure> figures;
  add_figures("path_traced, " + scene.objects[0].name, scene, figures);
  scene.objects[0].mesh = make_sphere(choice.height / 2, 20000);
  add_figures("path_traced, sphere", scene, figures);
  return figures;
}

}  // namespace opaline::bench
