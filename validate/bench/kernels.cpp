// Inner loops on one core against the machine's own limit, through Google Benchmark.
#include "model/profiles/profile.h"
#include "model/simd.h"
#include "render/irradiance/profile_sum.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "validate/bench/kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace opaline::bench::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Ten independent chains (more would not fit AVX2's registers) of fused multiply-adds; returns the flops done.
double fma_peak(float* sink) {
  const hn::ScalableTag<float> d;
  constexpr int chains = 10, rounds = 4096;
  hn::Vec<decltype(d)> x[chains];
  for (int i = 0; i < chains; ++i) x[i] = hn::Set(d, static_cast<float>(i));
  const auto a = hn::Set(d, 0.999f), b = hn::Set(d, 0.001f);
  for (int r = 0; r < rounds; ++r)
    for (int i = 0; i < chains; ++i) x[i] = hn::MulAdd(x[i], a, b);
  for (int i = 0; i < chains; ++i) *sink += hn::GetLane(x[i]);
  return 2.0 * chains * rounds * static_cast<double>(hn::Lanes(d));
}

}  // namespace opaline::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <benchmark/benchmark.h>

#include <random>

namespace opaline::bench {

HWY_EXPORT(fma_peak);

namespace {

void bench_fma(benchmark::State& state, const std::string& target) {
  limit_simd_target(target);
  float sink = 0;
  double flops = 0;
  for (auto _ : state) flops += HWY_DYNAMIC_DISPATCH(fma_peak)(&sink);
  benchmark::DoNotOptimize(sink);
  state.counters["FLOP"] = benchmark::Counter(flops, benchmark::Counter::kIsRate);
  limit_simd_target("");
}

PatchList random_patches(int count) {
  ClusterTree tree;
  std::mt19937 generator(1);
  std::uniform_real_distribution<float> place(-5, 5);
  PatchList patches;
  for (int i = 0; i < count; ++i) {
    ClusterNode node{};
    node.centroid = {place(generator), place(generator), place(generator)};
    node.covariance[0] = node.covariance[3] = 1e-3f;
    tree.nodes.push_back(node);
    tree.mass.push_back(1);
    patches.push(tree, static_cast<std::size_t>(i));
  }
  patches.pad();
  return patches;
}

/// Two RGB evaluations a patch (the two-point rule).
void bench_profile_sum(benchmark::State& state, const std::string& target) {
  limit_simd_target(target);
  const PatchList patches = random_patches(1024);
  std::vector<ProfileTable> tables;
  ProfileSum sum;
  sum.table_count = 3;
  for (const double sigma_a : {0.0011, 0.0024, 0.014}) {
    const auto profile = profiles().front().make({sigma_a, 3, 1.3});
    tables.emplace_back([&](double r) { return profile->evaluate(r); }, 0.32, 20.0);
  }
  for (std::size_t t = 0; t < 3; ++t) sum.tables[t] = &tables[t], sum.table_of[t] = static_cast<int>(t);
  float sums[3] = {0, 0, 0};
  for (auto _ : state) add_profile_sum(sum, patches, nullptr, {0.1f, 0.2f, 0.3f}, sums);
  benchmark::DoNotOptimize(sums[0]);
  state.counters["RGB_eval"] =
      benchmark::Counter(2.0 * 1024 * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
  limit_simd_target("");
}

}  // namespace

double run_fma_peak(float* sink) { return HWY_DYNAMIC_DISPATCH(fma_peak)(sink); }

void register_kernels() {
  for (const std::string& target : simd_targets()) {
    benchmark::RegisterBenchmark(("fma_peak/" + target).c_str(), bench_fma, target);
    benchmark::RegisterBenchmark(("profile_sum_rgb/" + target).c_str(), bench_profile_sum, target);
  }
}

}  // namespace opaline::bench
#endif
