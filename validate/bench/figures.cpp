#include "validate/bench/figures.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "model/materials/library.h"
#include "model/simd.h"
#include "render/input_error.h"
#include "render/stopwatch.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <thread>

namespace opaline::bench {

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

double median_processor_seconds(int runs, const std::function<void()>& call) {
  call();
  std::vector<double> seconds;
  for (int i = 0; i < runs; ++i) {
    const std::clock_t start = std::clock();
    call();
    seconds.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
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

Material library_material(const std::string& name) {
  const MaterialRow* row = find_material(name);
  if (!row) throw InputError("--material", "", name + " is not in the library; `opaline material list` shows it");
  Material material;
  material.name = row->name;
  for (int c = 0; c < 3; ++c) {
    material.sigma_a[c] = row->sigma_a[static_cast<std::size_t>(c)];
    material.sigma_s_prime[c] = row->sigma_s_prime[static_cast<std::size_t>(c)];
  }
  material.eta = row->eta;
  return material;
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
  scene.materials.push_back(library_material(choice.material));
  return scene;
}

}  // namespace opaline::bench
