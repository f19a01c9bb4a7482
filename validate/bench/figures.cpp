#include "validate/bench/figures.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "model/materials/library.h"
#include "model/simd.h"
#include "render/input_error.h"
#include "render/stopwatch.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <thread>

namespace opaline::bench {
namespace {

double rms_error(const Frame& frame, const Frame& reference, std::size_t step) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < reference.exitance.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double r = static_cast<double>(reference.exitance[i][c]);
      const double d = static_cast<double>(frame.exitance[i * step][c]) - r;
      error += d * d;
      norm += r * r;
    }
  return std::sqrt(error / norm);
}

Frame render_once(const SharedScene& shared, const std::string& name, const std::map<std::string, std::string>& given,
                  const GBuffer& view) {
  const Technique& technique = find_technique(name);
  return technique.prepare(shared, Settings(technique.settings, given))->render(view);
}

/// Every `step`-th point of the view.
GBuffer thinned(const GBuffer& view, std::size_t step) {
  GBuffer some{view.width, view.height, {}, {}};
  for (std::size_t i = 0; i < view.points.size(); i += step) some.points.push_back(view.points[i]);
  return some;
}

bool same_for_one_thread(const Scene& scene, const SharedSettings& settings, const Frame& frame) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const SharedScene shared(scene, settings);
  return render_once(shared, "hierarchical", {}, shared.view).exitance == frame.exitance;
}

}  // namespace

void print_figures(const std::string& title, const std::vector<Figure>& figures) {
  fmt::print("\n{}\n{:<58}{:>12}  {:<10}{:<14}\n", title, "", "reached", "unit", "asked");
  for (const Figure& f : figures) {
    std::string asked;
    if (f.asked != 0)
      asked = fmt::format("{} {:.4g}{}", f.at_most ? "<=" : ">=", f.asked,
                          (f.reached <= f.asked) == f.at_most ? "" : "  SHORT");
    fmt::print("{:<58}{:>12.4g}  {:<10}{:<14}{}\n", f.name, f.reached, f.unit, asked, f.note);
  }
}

std::string machine() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  std::string model = "unknown processor";
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.rfind("model name", 0) == 0) {
      model = line.substr(line.find(':') + 2);
      break;
    }
  return fmt::format("{}, {} threads, vector target {}, compiler {}", model, std::thread::hardware_concurrency(),
                     simd_target(), __VERSION__);
}

double median_seconds(int runs, const std::function<void()>& call) {
  call();
  std::vector<double> seconds;
  for (int i = 0; i < runs; ++i) {
    Stopwatch watch;
    call();
    seconds.push_back(watch.lap());
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[seconds.size() / 2];
}

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double peak_rss() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

Scene bench_scene(const SceneChoice& choice) {
  Scene scene;
  scene.film = {choice.film, choice.film};
  Object object;
  object.name = choice.mesh.empty() ? "bust" : choice.mesh;
  object.mesh = choice.mesh.empty() ? make_bust(choice.height, 69000) : load_mesh(choice.mesh);
  validate_mesh(object.mesh, ZeroAreaTriangles::drop, object.name, "");
  glm::vec3 lo(object.mesh.positions.front()), hi(lo);
  for (const glm::vec3& p : object.mesh.positions) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const float scale = static_cast<float>(choice.height) / (hi.y - lo.y);
  for (glm::vec3& p : object.mesh.positions) p = scale * (p - 0.5f * (lo + hi));
  scene.objects.push_back(std::move(object));
  scene.camera.position = {0, 0, 5 * choice.height};
  scene.camera.fov_y_deg = 12.5;
  scene.lights.emplace_back(DirectionalLight{glm::normalize(glm::dvec3(-0.87, -0.2, -0.5)), Rgb(pi), 0});
  const MaterialRow* row = find_material(choice.material);
  if (!row)
    throw InputError("--material", "", choice.material + " is not in the library; `opaline material list` shows it");
  Material material;
  material.name = row->name;
  for (int c = 0; c < 3; ++c) {
    material.sigma_a[c] = row->sigma_a[static_cast<std::size_t>(c)];
    material.sigma_s_prime[c] = row->sigma_s_prime[static_cast<std::size_t>(c)];
  }
  material.eta = row->eta;
  scene.materials.push_back(material);
  return scene;
}

std::vector<Figure> render_figures(const SceneChoice& choice) {
  const Scene scene = bench_scene(choice);
  const SharedSettings settings{choice.samples, {}};
  const double shared_seconds = median_seconds(choice.runs, [&] { const SharedScene shared(scene, settings); });
  const SharedScene shared(scene, settings);
  const double points = static_cast<double>(shared.view.points.size());
  const std::size_t step = std::max<std::size_t>(1, shared.view.points.size() / 1000);
  const Frame oracle = render_once(shared, "brute_force", {}, thinned(shared.view, step));
  std::vector<Figure> figures = {{"object pixels", points, 0, true, "", ""},
                                 {"G-buffer, surface cells and irradiance", shared_seconds, 0, true, "s", ""}};
  Frame default_frame;
  const auto measure = [&](const std::string& label, const std::map<std::string, std::string>& given, double asked) {
    Frame frame;
    const double seconds =
        median_seconds(choice.runs, [&] { frame = render_once(shared, "hierarchical", given, shared.view); });
    figures.push_back(
        {"hierarchical, " + label + ": tree and picture", seconds, 0, true, "s",
         fmt::format("{:.0f} clusters a query", static_cast<double>(frame.counters.done["clusters"]) / points)});
    figures.push_back({"  error against brute_force (rms)", rms_error(frame, oracle, step), 0, true, "", ""});
    if (asked > 0) {
      figures.push_back({"  whole picture from the loaded scene", seconds + shared_seconds, asked, true, "s", ""});
      default_frame = frame;
    }
  };
  measure("tolerance 1e-3", {}, 1.0);
  measure("tolerance 1e-2", {{"max_relative_error", "1e-2"}}, 0);
  measure("tolerance 1e-4", {{"max_relative_error", "1e-4"}}, 0);
  measure("solid angle 0.2, as published", {{"criterion", "solid_angle"}}, 0);
  measure("solid angle 0.02, as published", {{"criterion", "solid_angle"}, {"quality", "0.02"}}, 0);
  figures.push_back({"pixels that differ with one thread (0: same picture)",
                     same_for_one_thread(scene, settings, default_frame) ? 0.0 : 1.0, 0.5, true, "", ""});
  return figures;
}

}  // namespace opaline::bench
