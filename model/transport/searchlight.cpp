#include "model/transport/walk.h"

#include <cmath>
#include <stdexcept>

namespace opaline {
namespace {

Estimate scaled(const Estimate& e, double factor) { return {e.value * factor, e.standard_error * factor}; }

/// Adds up the scores of all walks and their squares.
struct Tally {
  double sum = 0, squares = 0;

  void add(double count, double score) {
    sum += count * score;
    squares += count * score * score;
  }

  Estimate mean(double walks) const {
    const double value = sum / walks, variance = std::max(0.0, squares / walks - value * value);
    return {value, std::sqrt(variance / walks)};
  }
};

/// What one walk scores, by its number of scatterings: both weights contain the roulette.
struct Scores {
  std::vector<double> leaving;   // albedo^n
  std::vector<double> absorbed;  // sum over its scatterings of albedo^(n-1) (1 - albedo)

  Scores(const WalkCounts& counts, double albedo) {
    double weight = 1, lost = 0;
    for (std::size_t n = 0; n < counts.rows(); ++n) {
      leaving.push_back(weight);
      absorbed.push_back(lost);
      lost += weight * (1 - albedo);
      weight *= n < counts.free_scatterings ? albedo : albedo / counts.survival;
    }
  }
};

struct Face {
  Tally all, unscattered, once;
  std::vector<Tally> bins, once_in_bin;

  Face(const std::vector<std::uint64_t>& counts, std::size_t bin_count, const Scores& scores)
      : bins(bin_count), once_in_bin(bin_count) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] == 0) continue;
      const std::size_t n = i / bin_count, bin = i % bin_count;
      const auto count = static_cast<double>(counts[i]);
      const double score = scores.leaving[n];
      all.add(count, score);
      if (n == 0) unscattered.add(count, score);
      if (n > 0) bins[bin].add(count, score);
      if (n == 1) once.add(count, score);
      if (n == 1) once_in_bin[bin].add(count, score);
    }
  }

  std::vector<AnnulusEstimate> annuli(const std::vector<double>& radii, double walks) const {
    std::vector<AnnulusEstimate> result;
    for (std::size_t i = 0; i + 1 < radii.size(); ++i) {
      const double area = pi * (radii[i + 1] - radii[i]) * (radii[i + 1] + radii[i]);
      result.push_back({radii[i], radii[i + 1], scaled(bins[i].mean(walks), 1 / area),
                        scaled(once_in_bin[i].mean(walks), 1 / area)});
    }
    return result;
  }
};

struct Inside {
  Tally absorbed, balance;

  Inside(const WalkCounts& counts, const Scores& scores) {
    const std::size_t bins = counts.annuli.bins();
    for (std::size_t n = 0; n < counts.rows(); ++n) {
      double left = 0;
      for (std::size_t i = n * bins; i < (n + 1) * bins; ++i) {
        left += static_cast<double>(counts.reflected[i]);
        if (!counts.transmitted.empty()) left += static_cast<double>(counts.transmitted[i]);
      }
      const auto killed = static_cast<double>(counts.killed[n]);
      absorbed.add(left + killed, scores.absorbed[n]);
      balance.add(left, scores.absorbed[n] + scores.leaving[n]);
      balance.add(killed, scores.absorbed[n]);
    }
  }
};

/// Lengths from mean free paths to mm.
void rescale(std::vector<AnnulusEstimate>& annuli, double sigma_t) {
  const double density = sigma_t * sigma_t;
  for (AnnulusEstimate& a : annuli) {
    a.inner /= sigma_t;
    a.outer /= sigma_t;
    a.exitance = scaled(a.exitance, density);
    a.once = scaled(a.once, density);
  }
}

SearchlightResult walk_medium(const Searchlight& s, double thickness_mm) {
  const double sigma_s = s.medium.sigma_s_prime / (1 - s.g), sigma_t = s.medium.sigma_a + sigma_s;
  if (!(s.medium.sigma_a >= 0 && sigma_s > 0 && std::isfinite(sigma_t)))
    throw std::invalid_argument("transport: sigma_a must be >= 0 and sigma_s_prime > 0");
  const double albedo = sigma_s / sigma_t;
  WhiteWalk walk;
  walk.g = s.g;
  walk.eta = s.medium.eta;
  walk.optical_thickness = sigma_t * thickness_mm;
  walk.cos_incident = s.cos_incident;
  walk.roulette_albedo = albedo;
  for (const double r : s.radii) walk.radii.push_back(r * sigma_t);
  walk.walks = s.walks;
  walk.seed = s.seed;
  SearchlightResult result = searchlight_at(white_walk(walk), albedo);
  rescale(result.reflectance, sigma_t);
  rescale(result.transmittance, sigma_t);
  return result;
}

}  // namespace

Estimate SearchlightResult::reflected_per_incident() const { return scaled(reflected, 1 - specular); }

Estimate SearchlightResult::reflected_per_incident_with_specular() const {
  const Estimate diffuse = reflected_per_incident();
  return {specular + diffuse.value, diffuse.standard_error};
}

Estimate SearchlightResult::transmitted_per_incident() const { return scaled(transmitted, 1 - specular); }

SearchlightResult searchlight_at(const WalkCounts& counts, double albedo) {
  if (!(albedo >= 0 && albedo <= 1)) throw std::invalid_argument("transport: albedo must be in [0, 1]");
  const Scores scores(counts, albedo);
  const std::size_t bins = counts.annuli.bins();
  const Face top(counts.reflected, bins, scores), bottom(counts.transmitted, bins, scores);
  const Inside inside(counts, scores);
  const auto walks = static_cast<double>(counts.walks);
  SearchlightResult r;
  r.specular = counts.specular;
  r.reflected = top.all.mean(walks);
  r.transmitted = bottom.all.mean(walks);
  r.absorbed = inside.absorbed.mean(walks);
  r.balance = inside.balance.mean(walks);
  r.unscattered_reflected = top.unscattered.mean(walks);
  r.unscattered_transmitted = bottom.unscattered.mean(walks);
  r.once_reflected = top.once.mean(walks);
  r.once_transmitted = bottom.once.mean(walks);
  r.reflectance = top.annuli(counts.annuli.radii(), walks);
  if (!counts.transmitted.empty()) r.transmittance = bottom.annuli(counts.annuli.radii(), walks);
  r.walks = counts.walks;
  r.scatterings = counts.scatterings;
  return r;
}

SearchlightResult walk_half_space(const Searchlight& searchlight) {
  return walk_medium(searchlight, std::numeric_limits<double>::infinity());
}

SearchlightResult walk_slab(const Searchlight& searchlight, double thickness_mm) {
  return walk_medium(searchlight, thickness_mm);
}

}  // namespace opaline
