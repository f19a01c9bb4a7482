// The inner loops of model/ and render/ on one core beside the processor's own limit, for every vector target.
//
// Seconds are processor time of this thread, the best of many short runs, so that a busy machine shows its speed all
// the same; the share of the FMA peak measured in the same minute is the figure to compare. Flops are those of the
// formula (a fused multiply-add is two), not of what the compiler made of it:
//   table    RGB value: 3 polynomials of degree 6 (cubics below AVX-512) and weighted sums, 4 to find the place
//   pair     a cell and a point: two points (41) and two RGB values
//   dipole   RGB value: 6 poles of 75, most of them for the exponential and the rounding errors it needs
#include "validate/bench/figures.h"

#include "model/profile_batch.h"
#include "model/profiles/dipole_batch.h"
#include "model/simd.h"
#include "render/irradiance/profile_sum.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace opaline::bench {

double run_fma_peak(float* sink);  // kernels.cpp

namespace {

/// Most of what call() returns, per second.
double best_rate(const std::function<double()>& call) {
  double best = 0;
  for (int i = 0; i < 60; ++i) {
    const double start = thread_seconds(), done = call();
    best = std::max(best, done / (thread_seconds() - start));
  }
  return best;
}

/// Whole milk and what is summed over it: 1e5 cells over a ball of 10 mm.
struct Setting {
  static constexpr double core = 1 / 3.771, range = 20;
  StandardDipole<double> dipoles[3] = {StandardDipole<double>({0.0011, 2.55, 1.3}),
                                       StandardDipole<double>({0.0024, 3.21, 1.3}),
                                       StandardDipole<double>({0.014, 3.77, 1.3})};
  std::vector<ProfileTable> tables;
  ProfileSum sum;
  PatchList patches;
  std::vector<glm::vec3> points;
  std::vector<float> r2, weight;

  explicit Setting(double r_max = range) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    const auto on_sphere = [&] {
      return 10.0f * glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
    };
    for (const auto& dipole : dipoles)
      tables.emplace_back([&dipole](double r) { return dipole.evaluate(r); }, core, r_max);
    sum.table_count = 3;
    for (int t = 0; t < 3; ++t) sum.tables[t] = &tables[static_cast<std::size_t>(t)], sum.table_of[t] = t;
    ClusterTree tree;
    ClusterNode node{};
    node.covariance[0] = node.covariance[3] = 5e-4f;
    tree.mass = {4 * 3.14159265f * 100 / 1e5f};
    for (int i = 0; i < 100000; ++i) {
      node.centroid = on_sphere();
      tree.nodes = {node};
      patches.push(tree, 0);
    }
    patches.pad();
    for (int i = 0; i < 64; ++i) points.push_back(on_sphere());
    for (int i = 0; i < 2048; ++i) {
      const glm::vec3 d = on_sphere() - on_sphere();
      r2.push_back(glm::dot(d, d));
      weight.push_back(1);
    }
  }

  double add_tables() const {
    const ProfileTable* all[] = {&tables[0], &tables[1], &tables[2]};
    double sums[3] = {};
    for (int i = 0; i < 50; ++i) sum_tables(all, 3, r2.data(), weight.data(), r2.size(), sums);
    return sums[0] > 0 ? 50.0 * static_cast<double>(r2.size()) : 0;
  }
  double add_pairs() const {
    std::array<std::array<float, 3>, 64> sums{};
    add_profile_sums(sum, patches, nullptr, points, sums.data());
    return sums[0][0] > 0 ? static_cast<double>(points.size() * patches.size()) : 0;
  }
  double evaluate_dipoles() const {
    std::vector<float> out[3] = {r2, r2, r2};
    for (int i = 0; i < 20; ++i)
      evaluate_dipoles_rgb(dipoles, r2.data(), r2.size(), {out[0].data(), out[1].data(), out[2].data()});
    return 20.0 * static_cast<double>(r2.size());
  }

  /// Worst relative error of the table kernel's sums over the points' distances, against doubles.
  double sum_error() const {
    const ProfileTable* all[] = {&tables[0], &tables[1], &tables[2]};
    double sums[3] = {}, worst = 0;
    sum_tables(all, 3, r2.data(), weight.data(), r2.size(), sums);
    for (std::size_t c = 0; c < 3; ++c) {
      double exact = 0;
      for (const float q : r2) exact += dipoles[c].evaluate_squared(static_cast<double>(q));
      worst = std::max(worst, std::abs(sums[c] / exact - 1));
    }
    return worst;
  }
};

double dipole_error(const Setting& s) {
  std::vector<float> out[3] = {s.r2, s.r2, s.r2};
  evaluate_dipoles_rgb(s.dipoles, s.r2.data(), s.r2.size(), {out[0].data(), out[1].data(), out[2].data()});
  double worst = 0;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < s.r2.size(); ++i)
      worst = std::max(
          worst,
          std::abs(static_cast<double>(out[c][i]) / s.dipoles[c].evaluate_squared(static_cast<double>(s.r2[i])) - 1));
  return worst;
}

/// What is asked of AVX-512 and of AVX2; nothing of older targets.
double asked(const std::string& target, double avx512, double avx2) {
  return target.rfind("AVX3", 0) == 0 ? avx512 : target == "AVX2" ? avx2 : 0;
}

/// The technique, with finding and splitting near cells, on a dense view.
Figure brute_force_figure(const std::string& target) {
  SceneChoice choice;
  choice.film = 48;
  const Scene scene = bench_scene(choice);
  const SharedScene shared(scene, {choice.samples, {}});
  const Technique& technique = find_technique("brute_force");
  const auto prepared = technique.prepare(shared, Settings(technique.settings, {}));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  double rate = 0, parts = 0;
  for (int run = 0; run < 3; ++run) {
    const double start = thread_seconds();
    const Frame frame = prepared->render(shared.view);
    const auto whole = static_cast<double>(frame.counters.done.at("cells"));
    parts = static_cast<double>(frame.counters.done.at("cell_parts"));
    rate = std::max(rate, (whole + parts) / (thread_seconds() - start));
  }
  return {
      target + ": brute_force, RGB values (two a pair)",
      2 * rate / 1e6,
      asked(target, 900, 360),
      false,
      "M/s",
      fmt::format("{:.0f} M pairs/s; {} points x {} cells, {:.0f} parts a point", rate / 1e6, shared.view.points.size(),
                  shared.cells[0].size(), parts / static_cast<double>(shared.view.points.size()))};
}

}  // namespace

std::vector<Figure> kernel_figures() {
  std::vector<Figure> figures;
  const Setting near, far(400);
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    float sink = 0;
    const double peak = best_rate([&] { return run_fma_peak(&sink); });
    const auto row = [&](const std::string& name, double rate, double flops, double wanted, const std::string& note) {
      figures.push_back({target + ": " + name, rate / 1e6, wanted, false, "M/s",
                         fmt::format("{:.0f} % of the FMA peak{}", 100 * rate * flops / peak, note)});
    };
    const bool registers = asked(target, 1, 0) > 0;
    const double table_flops = registers ? 46 : 28, pair_flops = 41 + 2 * table_flops;
    figures.push_back({target + ": FMA peak", peak / 1e9, 0, false, "GFLOP/s", ""});
    row("batch dipole, RGB values", best_rate([&] { return near.evaluate_dipoles(); }), 450, asked(target, 300, 200),
        "");
    figures.push_back({"  worst relative error", dipole_error(near), 1e-6, true, "", ""});
    const double table_rate = best_rate([&] { return near.add_tables(); });
    row("table kernel, RGB values", table_rate, table_flops, asked(target, 900, 360), "");
    figures.push_back({"  relative error of the sum", near.sum_error(), 1e-5, true, "", ""});
    row("table kernel beyond 210 core radii", best_rate([&] { return far.add_tables(); }), table_flops + 12, 0, "");
    const double pairs = best_rate([&] { return near.add_pairs(); });
    row("all pairs, RGB values (two a pair)", 2 * pairs, pair_flops / 2, asked(target, 900, 360),
        fmt::format("; {:.0f} M pairs/s", pairs / 1e6));
    if (asked(target, 1, 1) > 0) figures.push_back(brute_force_figure(target));
  }
  limit_simd_target("");
  return figures;
}

}  // namespace opaline::bench
