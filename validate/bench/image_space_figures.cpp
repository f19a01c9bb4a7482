// Image-space sampling: time, cost against pixels and samples, error against samples, and what no sample removes.
#include "validate/bench/figures.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "render/gl/context.h"
#include "render/input_error.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace opaline::bench {
namespace {

using Given = std::map<std::string, std::string>;

Frame render(const SharedScene& shared, const std::string& name, const Given& given) {
  const Technique& technique = find_technique(name);
  return technique.prepare(shared, Settings(technique.settings, given))->render(shared.view);
}

/// Against a reference, over all channels: RMS error over its RMS, as it is and after the best single factor.
struct Error {
  double rms, factor, rms_after_factor;
};

Error error_against(const std::vector<glm::vec3>& image, const std::vector<glm::vec3>& reference) {
  double rr = 0, ri = 0, ii = 0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const glm::dvec3 r(reference[i]), a(image[i]);
    rr += glm::dot(r, r), ri += glm::dot(r, a), ii += glm::dot(a, a);
  }
  const auto root = [&](double s) { return std::sqrt(std::max(s, 0.0) / rr); };
  if (ii == 0) return {1, 0, 1};
  return {root(rr - 2 * ri + ii), ri / ii, root(rr - ri * ri / ii)};
}

Scene scene_of(const std::string& shape, const std::string& material, bool back_lit, int film) {
  SceneChoice choice;
  choice.material = material, choice.film = film;
  Scene scene = bench_scene(choice);
  if (shape == "sphere") {
    scene.objects[0].mesh = make_sphere(15, 20000);
    scene.objects[0].name = "sphere";
  }
  const glm::dvec3 direction = back_lit ? glm::dvec3(-0.4, -0.2, 0.9) : glm::dvec3(-0.4, -0.2, -0.9);
  scene.lights = {DirectionalLight{glm::normalize(direction), Rgb(pi), 0}};
  return scene;
}

/// Slope of log seconds over log work, least squares.
double exponent(const std::vector<std::pair<double, double>>& work_seconds) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [work, seconds] : work_seconds) {
    const double u = std::log(work), v = std::log(seconds);
    n += 1, x += u, y += v, xx += u * u, xy += u * v;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

std::vector<Figure> time_figures(const SceneChoice& choice) {
  std::vector<Figure> figures;
  const Technique& technique = find_technique("image_space_sampling");
  std::vector<std::pair<double, double>> cost;
  for (const int film : {125, 250, 500}) {
    const Scene scene = scene_of("bust", "skin1", false, film);
    const SharedScene shared(scene, {1, {}}, false);
    const double points = static_cast<double>(shared.view.points.size());
    // The irradiance image is of the same size for every N: the difference of two N is the gather alone.
    double base = 0;
    for (const int n : {64, 256, 1024}) {
      const auto prepared =
          technique.prepare(shared, Settings(technique.settings, {{"samples_per_pixel", std::to_string(n)}}));
      const double seconds = median_seconds(choice.runs, [&] { prepared->render(shared.view); });
      if (n == 64) base = seconds;
      if (n > 64) cost.emplace_back(points * (n - 64), seconds - base);
      if (film == 500 && n == 64) {
        figures.push_back({"500 x 500, N = 64: a frame (irradiance and gather)", 1e3 * seconds, 60, true, "ms",
                           fmt::format("{:.0f} object pixels", points)});
        figures.push_back({"  processor time of all threads, on two idle cores twice as fast",
                           1e3 * median_processor_seconds(choice.runs, [&] { prepared->render(shared.view); }), 120,
                           true, "ms", ""});
      }
      if (film == 500 && n == 1024)
        figures.push_back(
            {"  of which the gather", 1e3 * (seconds - base) / 15, 60, true, "ms", "from N = 64 and 1024"});
    }
  }
  const double power = exponent(cost);
  figures.push_back({"cost of the gather: exponent of pixels x N, at most", power, 1.05, true, "", ""});
  figures.push_back({"  at least", power, 0.95, false, "", ""});
  return figures;
}

void gpu_figures(const SceneChoice& choice, std::vector<Figure>& figures) {
  const Technique& technique = find_technique("image_space_sampling");
  const Scene scene = scene_of("bust", "skin1", false, 500);
  const SharedScene shared(scene, {1, {}}, false);
  for (const gl::Api api : {gl::Api::any, gl::Api::egl}) {
    try {
      const auto context = gl::Context::create(api);
      const auto prepared = technique.prepare_gpu(shared, Settings(technique.settings, {}), *context);
      const double seconds = median_seconds(choice.runs, [&] { prepared->render(shared.view); });
      figures.push_back({"gpu: a frame, 500 x 500, N = 64, after warm-up", 1e3 * seconds, 120, true, "ms",
                         context->info().description()});
      figures.push_back({"  processor time of all threads",
                         1e3 * median_processor_seconds(choice.runs, [&] { prepared->render(shared.view); }), 240, true,
                         "ms", ""});
    } catch (const MachineError& error) {
      fmt::print("gpu left out: {}\n", error.what());
    }
  }
}

/// Errors for growing N, the residual (the mean of many seeds of the largest N) and its best factor.
void print_errors(const std::string& shape, const std::string& material, bool back_lit, const std::string& views) {
  const Scene scene = scene_of(shape, material, back_lit, 128);
  const SharedScene reference_scene(scene, {100000, {}});
  const Frame reference = render(reference_scene, "hierarchical", {{"max_relative_error", "1e-4"}});
  std::string row;
  std::vector<std::pair<double, double>> noise;
  const auto frame = [&](int n, std::uint64_t seed) {
    const SharedScene shared(scene, {1, {.seed = seed}}, false);
    return render(shared, "image_space_sampling", {{"samples_per_pixel", std::to_string(n)}, {"views", views}});
  };
  std::vector<glm::vec3> mean(reference.exitance.size(), glm::vec3(0));
  constexpr int seeds = 8;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Frame f = frame(1024, 100 + seed);
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += f.exitance[i] / static_cast<float>(seeds);
  }
  const Error residual = error_against(mean, reference.exitance);
  for (const int n : {8, 32, 128, 512, 1024}) {
    const Frame f = frame(n, 1);
    row += fmt::format("{:>9.4f}", error_against(f.exitance, reference.exitance).rms);
    const double spread = error_against(f.exitance, mean).rms;
    if (spread > 0) noise.emplace_back(n, spread);
  }
  fmt::print("{:<7}{:<10}{:<6}{:<13}{}{:>9.2f}{:>10.4f}{:>9.4f}{:>10.4f}\n", shape, material,
             back_lit ? "back" : "front", views, row, noise.size() > 1 ? exponent(noise) : 0, residual.rms,
             residual.factor, residual.rms_after_factor);
}

/// Seconds of the smallest setting of a list that is within 1 % of the reference, or 0.
double seconds_to_one_percent(const SharedScene& shared, const std::vector<glm::vec3>& reference,
                              const std::string& technique, const std::vector<Given>& settings, int runs) {
  for (const Given& given : settings) {
    const Frame f = render(shared, technique, given);
    if (error_against(f.exitance, reference).rms > 0.01) continue;
    return median_seconds(runs, [&] { render(shared, technique, given); });
  }
  return 0;
}

void print_speed_up(const std::string& shape, const std::string& material, int runs) {
  const Scene scene = scene_of(shape, material, false, 256);
  const SharedScene shared(scene, {100000, {}});
  const Frame reference = render(shared, "hierarchical", {{"max_relative_error", "1e-4"}});
  std::vector<Given> tolerances, counts;
  for (const char* t : {"1e-1", "5e-2", "2e-2", "1e-2"}) tolerances.push_back({{"max_relative_error", t}});
  for (const char* views : {"camera", "camera+light"})
    for (const char* n : {"32", "64", "128", "256", "512", "1024"})
      counts.push_back({{"samples_per_pixel", n}, {"views", views}});
  const double gather = seconds_to_one_percent(shared, reference.exitance, "hierarchical", tolerances, runs);
  const double sampled = seconds_to_one_percent(shared, reference.exitance, "image_space_sampling", counts, runs);
  fmt::print("{:<7}{:<10} hierarchical {:>7.0f} ms + irradiance of its cells {:>6.0f} ms   image space {}\n", shape,
             material, 1e3 * gather, 1e3 * shared.seconds.irradiance,
             sampled > 0 ? fmt::format("{:>7.0f} ms: {:.2f} times as fast", 1e3 * sampled,
                                       (gather + shared.seconds.irradiance) / sampled)
                         : "does not reach 1 %");
}

}  // namespace

void print_image_space_figures(const SceneChoice& choice) {
  std::vector<Figure> figures = time_figures(choice);
  gpu_figures(choice, figures);
  print_figures("Image-space sampling: bust of skin1", figures);
  fmt::print(
      "\nRelative RMS error against the hierarchical reference (1e-4); noise ~ N^slope; residual: mean of 8 seeds of "
      "N = 1024,\nas it is, the factor that fits it best, and what is left after it\n"
      "{:<36}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>10}{:>9}{:>10}\n",
      "", "N = 8", "32", "128", "512", "1024", "slope", "residual", "factor", "after");
  for (const char* shape : {"sphere", "bust"})
    for (const char* material : {"skin1", "marble", "wholemilk"})
      for (const bool back_lit : {false, true})
        for (const char* views : {"camera", "camera+light"}) print_errors(shape, material, back_lit, views);
  fmt::print("\nTo 1 % RMS, front-lit, 256 x 256\n");
  for (const char* shape : {"sphere", "bust"})
    for (const char* material : {"skin1", "marble", "wholemilk"}) print_speed_up(shape, material, choice.runs);
}

}  // namespace opaline::bench
