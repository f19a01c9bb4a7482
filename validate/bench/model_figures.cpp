// Figures of model/: sampling, and the Monte-Carlo walk against numbers it does not know.
#include "validate/bench/figures.h"

#include "model/fresnel.h"
#include "model/profiles/profile.h"
#include "model/profiles/standard_dipole.h"
#include "model/transport/check.h"
#include "model/transport/split_mix.h"
#include "model/transport/walk.h"
#include "render/stopwatch.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace opaline::bench {
namespace {

double uniform(SplitMix& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

// --- sampling ---------------------------------------------------------------------------------------

/// Media from white to black, as far as the sampler's promises go.
Medium<double> random_medium(SplitMix& random) {
  const double sigma_t = std::pow(10, 6 * uniform(random) - 3), absorbed = std::pow(10, -12 * uniform(random));
  return {sigma_t * absorbed, sigma_t * (1 - absorbed), 1 + uniform(random)};
}

/// Steps of the standard dipole's sampler: the most of any input, corners first.
int most_steps(std::uint64_t count) {
  SplitMix random{11};
  int most = 0;
  const auto sample = [&](const StandardDipole<double>& d, double xi) {
    int steps = 0;
    sample_pole_pair(d.z_r, d.z_v, d.sigma_tr, d.near_share, xi, &steps);
    most = std::max(most, steps);
  };
  const double shares[] = {0, 1e-300, 1e-16, 1e-12, 1e-3, 0.5, 1 - 1e-3, 1 - 1e-12, 1 - 0x1p-53};
  for (const double absorbed : {0.0, 1e-300, 1e-15, 1e-12, 1e-6, 1e-3, 0.1, 0.5, 1 - 1e-15})
    for (const double eta : {0.3, 1 - 1e-9, 1.0, 1 + 1e-9, 1.3, 3.5})
      for (const double sigma_t : {1e-9, 1.0, 1e9})
        for (const double xi : shares)
          sample(StandardDipole<double>({sigma_t * absorbed, sigma_t * (1 - absorbed), eta}), xi);
  for (std::uint64_t i = 0; i < count;) {
    const StandardDipole<double> dipole(random_medium(random));
    for (int k = 0; k < 64; ++k, ++i) {
      const double u = uniform(random), small = std::pow(10, -16 * uniform(random));
      sample(dipole, k % 4 ? u : k % 8 ? small : 1 - small);
    }
  }
  return most;
}

double solve_nanoseconds() {
  const StandardDipole<double> dipole({0.0024, 3.21, 1.3});
  SplitMix random{5};
  std::vector<double> xi(1 << 16);
  for (double& x : xi) x = uniform(random);
  double sum = 0, best = HUGE_VAL;
  for (int run = 0; run < 15; ++run) {
    const double start = thread_seconds();
    for (const double x : xi) sum += dipole.sample(x);
    best = std::min(best, thread_seconds() - start);
  }
  return sum > 0 ? 1e9 * best / static_cast<double>(xi.size()) : 0;
}

/// Radii that part the profile's flux evenly, by bisection of its cumulative.
std::vector<double> even_edges(const Profile& profile, int bins) {
  std::vector<double> edges;
  for (int i = 1; i < bins; ++i) {
    const double flux = profile.total() * i / bins;
    double lo = edges.empty() ? 0 : edges.back(), hi = profile.core_radius() + 2 * lo;
    while (profile.cumulative(hi) < flux) hi *= 2;
    for (int k = 0; k < 60; ++k) (profile.cumulative(0.5 * (lo + hi)) < flux ? lo : hi) = 0.5 * (lo + hi);
    edges.push_back(lo);
  }
  return edges;
}

/// (chi^2 - degrees)/sqrt(2 degrees) of samples in bins of equal flux: a standard normal if the sampler is right.
double chi_squared_z(const Profile& profile, std::uint64_t samples) {
  constexpr int bins = 257;
  const std::vector<double> edges = even_edges(profile, bins);
  std::vector<std::uint64_t> count(bins, 0);
  SplitMix random{3};
  for (std::uint64_t i = 0; i < samples; ++i) {
    const double r = profile.sample(uniform(random));
    ++count[static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), r) - edges.begin())];
  }
  const double expected = static_cast<double>(samples) / bins;
  double chi_squared = 0;
  for (const std::uint64_t c : count) chi_squared += std::pow(static_cast<double>(c) - expected, 2) / expected;
  return (chi_squared - (bins - 1)) / std::sqrt(2.0 * (bins - 1));
}

void add_sampling(std::vector<Figure>& figures, std::uint64_t samples) {
  figures.push_back({"standard dipole's sampler: mean cost", solve_nanoseconds(), 80, true, "ns", "whole milk, green"});
  figures.push_back({"  most steps", static_cast<double>(most_steps(samples)), 8, true, "",
                     fmt::format("{} random inputs and the corners", samples)});
  for (const std::string& name : medium_profile_names()) {
    const auto profile = find_profile(name)->make({0.05, 1, 1.3});
    figures.push_back({"chi-squared of " + name + "'s sampler: |z|", std::abs(chi_squared_z(*profile, samples)), 4,
                       true, "sd", fmt::format("{} samples, 257 bins", samples)});
  }
}

// --- Monte-Carlo ------------------------------------------------------------------------------------

struct PlainWalks {
  double reflected = 0, standard_error = 0, seconds = 0;
  std::uint64_t scatterings = 0;
};

struct Photon {
  double x = 0, y = 0, z = 0, ux = 0, uy = 0, uz = 1;

  void fly(double length) { x += length * ux, y += length * uy, z += length * uz; }
  void scatter(SplitMix& random) {
    uz = 2 * uniform(random) - 1;
    const double sine = std::sqrt(1 - uz * uz), phi = 2 * pi * uniform(random);
    ux = sine * std::cos(phi), uy = sine * std::sin(phi);
  }
};

/// The walk as one would write it down: one photon at a time, doubles, isotropic, absorbed by chance.
PlainWalks plain_walks(double albedo, double eta, std::uint64_t walks) {
  SplitMix random{9};
  PlainWalks result;
  std::uint64_t left = 0;
  double squared_distance = 0;  // where it left is a result too: it must not be optimised away
  Stopwatch watch;
  for (std::uint64_t i = 0; i < walks; ++i) {
    Photon photon;
    for (;;) {
      photon.fly(-std::log(1 - uniform(random)));
      if (photon.z < 0) {
        if (uniform(random) >= fresnel_reflectance(-photon.uz, 1 / eta)) {
          ++left;
          squared_distance += photon.x * photon.x + photon.y * photon.y;
          break;
        }
        photon.z = -photon.z, photon.uz = -photon.uz;
      }
      ++result.scatterings;
      if (uniform(random) >= albedo) break;
      photon.scatter(random);
    }
  }
  result.seconds = watch.lap();
  const double n = static_cast<double>(walks);
  result.reflected = squared_distance > 0 ? static_cast<double>(left) / n : 0;
  result.standard_error = std::sqrt(result.reflected * (1 - result.reflected) / n);
  return result;
}

SearchlightResult timed_walk(int threads, std::uint64_t walks, double& seconds) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  Searchlight light{{0.1, 0.9, 1.3}, 0, 1, {}, walks, 1};
  seconds = HUGE_VAL;
  SearchlightResult result;
  for (int run = 0; run < 3; ++run) {
    Stopwatch watch;
    result = walk_half_space(light);
    seconds = std::min(seconds, watch.lap());
  }
  return result;
}

void add_walks(std::vector<Figure>& figures, std::uint64_t walks) {
  const auto some = std::max<std::uint64_t>(walks / 8, 1000000);
  double two_threads = 0, one_thread = 0;
  timed_walk(2, some, two_threads);
  const SearchlightResult vector = timed_walk(1, some, one_thread);
  const PlainWalks plain = plain_walks(0.9, 1.3, some / 4);
  const double rate = static_cast<double>(vector.scatterings) / one_thread,
               plain_rate = static_cast<double>(plain.scatterings) / plain.seconds;
  const double z =
      (plain.reflected - vector.reflected.value) / std::hypot(plain.standard_error, vector.reflected.standard_error);
  figures.push_back({"walks, alpha' 0.9, eta 1.3, two threads", 60 * static_cast<double>(some) / two_threads / 1e6, 100,
                     false, "M/min", ""});
  figures.push_back({"  scatterings a second, one thread", rate / 1e6, 0, false, "M/s", "64 photons side by side"});
  figures.push_back(
      {"  plain scalar loop", plain_rate / 1e6, 0, false, "M/s", "doubles, exact Fresnel, absorbed by chance"});
  figures.push_back({"  ratio", rate / plain_rate, 0, false, "", ""});
  figures.push_back({"  their reflectances agree: |z|", std::abs(z), 4, true, "sd", ""});
}

void add_transport_check(std::vector<Figure>& figures, std::uint64_t walks) {
  double worst = 0;
  for (const TransportCheckRow& row : transport_check(walks)) {
    figures.push_back({row.name + ": |z|", std::abs(row.z()), 3, true, "sd",
                       fmt::format("{:.6f}, walk {:.6f} +- {:.1e}", row.expected, row.reached, row.standard_error)});
    worst = std::max(worst, row.standard_error);
  }
  figures.push_back({"  largest standard error", worst, 1e-4, true, "", fmt::format("{} walks each", walks)});
}

}  // namespace

std::vector<Figure> model_figures(const ModelChoice& choice) {
  std::vector<Figure> figures;
  add_sampling(figures, choice.samples);
  add_walks(figures, choice.walks);
  add_transport_check(figures, choice.walks);
  return figures;
}

}  // namespace opaline::bench
