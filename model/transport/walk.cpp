#include "model/transport/walk.h"

#include "model/fresnel.h"
#include "model/transport/reflectance_table.h"
#include "model/transport/split_mix.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace opaline {
namespace {

constexpr std::uint64_t batch_walks = 1 << 16;
constexpr double roulette_steps = 0x1p31;

void require(bool condition, const char* what) {
  if (!condition) throw std::invalid_argument(std::string("transport: ") + what);
}

void require_valid(const WhiteWalk& w) {
  require(std::abs(w.g) < 1, "g must be in (-1, 1)");
  require(w.eta > 0 && std::isfinite(w.eta), "eta must be > 0");
  require(w.optical_thickness > 0, "the thickness must be > 0");
  require(w.cos_incident > 0 && w.cos_incident <= 1, "cos_incident must be in (0, 1]");
  require(w.roulette_albedo > 0 && w.roulette_albedo <= 1, "roulette_albedo must be in (0, 1]");
  require(w.roulette_albedo < 1 || std::isfinite(w.optical_thickness), "a half space needs roulette_albedo < 1");
  require(w.free_scatterings < (1u << 28), "free_scatterings must be below 2^28");
  require(w.walks > 0, "walks must be > 0");
  require(w.radii.size() < 60000, "there may be 60000 radii");
  require(std::is_sorted(w.radii.begin(), w.radii.end()) && (w.radii.empty() || w.radii.front() >= 0),
          "radii must be >= 0 and ascend");
  require(1 - (1 - w.cos_incident * w.cos_incident) / (w.eta * w.eta) > 0, "the beam is reflected totally");
}

WalkConstants constants_of(const WhiteWalk& w) {
  WalkConstants k;
  const double sine = std::sqrt((1 - w.cos_incident) * (1 + w.cos_incident)) / w.eta;
  k.g = static_cast<float>(w.g);
  k.thickness = static_cast<float>(w.optical_thickness);
  k.sine = static_cast<float>(sine);
  k.cosine = static_cast<float>(std::sqrt((1 - sine) * (1 + sine)));
  k.index_squared = static_cast<float>(std::max(1.0, w.eta * w.eta));
  k.reflectance = reflectance_table(w.eta);
  k.last_survivor = static_cast<std::int32_t>(std::max(1L, std::lround(w.roulette_albedo * roulette_steps)) - 1);
  k.free_scatterings = static_cast<std::int32_t>(w.free_scatterings);
  return k;
}

WalkCounts empty_counts(const WhiteWalk& w, const WalkConstants& k) {
  WalkCounts counts;
  counts.annuli = Annuli(w.radii);
  counts.optical_thickness = w.optical_thickness;
  counts.specular = fresnel_reflectance(w.cos_incident, w.eta);
  counts.survival = (k.last_survivor + 1.0) / roulette_steps;
  counts.free_scatterings = w.free_scatterings;
  return counts;
}

}  // namespace

WalkCounts white_walk(const WhiteWalk& walk) {
  require_valid(walk);
  const WalkConstants constants = constants_of(walk);
  const WalkCounts empty = empty_counts(walk, constants);
  tbb::enumerable_thread_specific<WalkCounts> per_thread(empty);
  const std::uint64_t batches = (walk.walks + batch_walks - 1) / batch_walks;
  const auto run = [&](std::uint64_t batch) {
    WalkCounts& counts = per_thread.local();
    const std::uint64_t walks = std::min(batch_walks, walk.walks - batch * batch_walks);
    const std::uint64_t seed = SplitMix{SplitMix{walk.seed}() + batch}();
    counts.scatterings += run_walks(constants, seed, walks, [&](const WalkEnds& ends) { counts.add(ends); });
    counts.walks += walks;
  };
  tbb::parallel_for(std::uint64_t{0}, batches, run, tbb::simple_partitioner());
  WalkCounts sum = empty;
  for (const WalkCounts& counts : per_thread) sum.add(counts);
  sum.trim();
  return sum;
}

}  // namespace opaline
