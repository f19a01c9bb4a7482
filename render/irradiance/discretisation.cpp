#include "render/irradiance/discretisation.h"

#include "model/check.h"
#include "render/irradiance/probes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace opaline {
namespace {

/// No cell's quarters differ: there is nothing that the cells could leave out.
bool evenly_lit(const SurfaceCells& cells, const IrradianceField& field) {
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (light_spread(field, i) > 1e-6f * brightest_light(field, i)) return false;
  return true;
}

/// Every quarter as a cell with its own irradiance.
void quarters_of(const SurfaceCells& cells, const IrradianceField& field, SurfaceCells& quarters,
                 IrradianceField& irradiance) {
  quarters.resize(4 * cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) split_in_four(cells[i], &quarters[4 * i]);
  irradiance = {field.etas, field.channels, field.colour, field.quarters, {}};
}

/// The larger part of the error is where a cell's irradiance varies, less so where the profile is wide against it.
std::vector<double> indicators(const SurfaceCells& cells, const IrradianceField& field, double core) {
  std::vector<double> all(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto area = static_cast<double>(cell_area(cells[i]));
    all[i] = area * static_cast<double>(light_spread(field, i)) * std::min(1.0, std::sqrt(area) / core);
  }
  return all;
}

/// The smallest set of cells that holds a part of the sum of the squared indicators; at most `most`.
std::vector<bool> mark(const std::vector<double>& indicator, double part, std::size_t most, std::size_t& refused) {
  std::vector<std::uint32_t> order(indicator.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return indicator[a] > indicator[b]; });
  double total = 0, held = 0;
  for (const double i : indicator) total += i * i;
  std::vector<bool> marked(indicator.size(), false);
  std::size_t count = 0;
  for (const std::uint32_t i : order) {
    if (held >= part * total || indicator[i] <= 0) break;
    held += indicator[i] * indicator[i];
    if (count < most)
      marked[i] = true, ++count;
    else
      ++refused;
  }
  return marked;
}

class Discretiser {
 public:
  Discretiser(const Scene& scene, const RayScene& rays, std::size_t object, const ChannelProfiles& profiles,
              const IrradianceSettings& light, const DiscretisationSettings& settings, Counters& counters)
      : scene_(scene),
        rays_(rays),
        object_(object),
        profiles_(profiles),
        light_(light),
        settings_(settings),
        counters_(counters) {}

  Discretisation run(SurfaceCells cells, IrradianceField irradiance) {
    Discretisation d{std::move(cells), std::move(irradiance), {}, 0, 0};
    d.tree = build_cluster_tree(d.cells, d.irradiance);
    estimate(d);
    while (d.error > settings_.max_relative_error && d.rounds < settings_.max_rounds && !take_quarters(d) && split(d)) {
      ++d.rounds;
      d.tree = build_cluster_tree(d.cells, d.irradiance);
      estimate(d);
    }
    counters_.done["discretisation_rounds"] += static_cast<std::uint64_t>(d.rounds);
    if (lit_again_) d.tree = build_cluster_tree(d.cells, d.irradiance);
    d.irradiance.quarters = {};
    return d;
  }

 private:
  /// Sets the error of d and fine_, all quarters with theirs: RMS over RMS of the channel that is worst.
  void estimate(Discretisation& d) {
    lit_again_ = false;
    d.error = 0;
    if (d.tree.nodes.empty() || evenly_lit(d.cells, d.irradiance)) {
      ++counters_.skipped["discretisation_estimates"];
      return;
    }
    quarters_of(d.cells, d.irradiance, fine_.cells, fine_.irradiance);
    const std::vector<std::uint32_t> edges = light_edges_again(d, fine_.cells, fine_.irradiance);
    fine_.tree = build_cluster_tree(fine_.cells, fine_.irradiance);
    const double left = jumps(d) ? of_jumps : of_smooth;
    d.error = difference(d, fine_) / (1 - left);
    fine_.error = left * d.error;
    adopt(edges, fine_.irradiance, d.irradiance);
  }

  double difference(const Discretisation& d, const Discretisation& of) {
    const Probes probes = make_probes(d.cells, d.irradiance);
    counters_.done["discretisation_points"] += probes.positions.size();
    const std::vector<glm::vec3> coarse = exitance(d, probes), fine = exitance(of, probes);
    double worst = 0;
    for (int c = 0; c < 3; ++c) {
      double error = 0, norm = 0;
      for (std::size_t i = 0; i < fine.size(); ++i) {
        const double f = static_cast<double>(fine[i][c]), e = static_cast<double>(coarse[i][c]) - f;
        error += probes.weights[i] * e * e, norm += probes.weights[i] * f * f;
      }
      if (norm > 0) worst = std::max(worst, std::sqrt(error / norm));
    }
    return worst;
  }

  /// If the quarters that were made for the estimate are good enough they are the answer: no light is needed for them,
  /// no further estimate, and a gather hardly minds four times the cells.
  bool take_quarters(Discretisation& d) {
    if (fine_.error > settings_.max_relative_error || fine_.cells.size() > settings_.max_cells) return false;
    counters_.done["cells_added_by_discretisation"] += fine_.cells.size() - d.cells.size();
    const int rounds = d.rounds + 1;
    d = std::move(fine_);
    d.rounds = rounds;
    lit_again_ = false;
    return true;
  }

  /// What splitting every cell in four leaves of the error: a quarter where the irradiance is smooth; where it jumps
  /// within cells that aren't small against the profile, half (measured on beams, tests/render).
  static constexpr double of_smooth = 0.25, of_jumps = 0.5;

  /// Whether an edge of light crosses some cell, which makes up most of the error then.
  static bool jumps(const Discretisation& d) {
    float light = 0;
    for (const float e : d.irradiance.values) light = std::max(light, e);
    for (std::size_t i = 0; i < d.cells.size(); ++i)
      if (light_spread(d.irradiance, i) > edge * light) return true;
    return false;
  }

  /// Four points don't find the flux of a cell that an edge of light crosses, and its quarters share their mistake:
  /// they get points of their own. Returns the cells.
  std::vector<std::uint32_t> light_edges_again(const Discretisation& d, const SurfaceCells& quarters,
                                               IrradianceField& field) {
    std::vector<std::uint32_t> crossed;
    SurfaceCells again;
    for (std::size_t i = 0; i < d.cells.size(); ++i) {
      const float bright = brightest_light(d.irradiance, i);
      if (bright <= 0 || light_spread(d.irradiance, i) < edge * bright) continue;
      crossed.push_back(static_cast<std::uint32_t>(i));
      again.insert(again.end(), &quarters[4 * i], &quarters[4 * i] + 4);
    }
    if (crossed.empty()) return crossed;
    const IrradianceField lit = object_irradiance(scene_, rays_, object_, again, d.cells.size(), light_, counters_);
    const auto stride = static_cast<std::ptrdiff_t>(4 * lit.width());
    for (std::size_t k = 0; k < crossed.size(); ++k)
      std::copy_n(lit.values.begin() + static_cast<std::ptrdiff_t>(k) * stride, stride,
                  field.values.begin() + static_cast<std::ptrdiff_t>(crossed[k]) * stride);
    return crossed;
  }

  /// What was found about those cells stays: the error of the cells given is below its estimate from here on.
  void adopt(const std::vector<std::uint32_t>& edges, const IrradianceField& quarters, IrradianceField& field) {
    const auto width = static_cast<std::size_t>(field.width());
    for (const std::uint32_t i : edges)
      for (std::size_t m = 0; m < width; ++m) {
        float sum = 0;
        for (std::size_t q = 0; q < 4; ++q) {
          const std::size_t at = (4 * i + q) * width + m;
          sum += field.quarters[at] = quarters.values[at];
        }
        field.values[i * width + m] = sum / 4;
      }
    lit_again_ |= !edges.empty();
  }
  static constexpr float edge = 0.2f;

  std::vector<glm::vec3> exitance(const Discretisation& d, const Probes& probes) const {
    Counters apart;
    return gather_exitance(d.tree, d.cells, profiles_, d.irradiance.colour, probes.positions,
                           {GatherSettings::Criterion::error, 0.5 * settings_.max_relative_error, 0}, apart);
  }

  /// Splits cells in four; false if none can be.
  bool split(Discretisation& d) {
    const double excess = d.error / settings_.max_relative_error;
    const double part = std::clamp(1 - 0.5 / (excess * excess), 0.5, 0.99);
    const std::size_t room = settings_.max_cells > d.cells.size() ? (settings_.max_cells - d.cells.size()) / 3 : 0;
    std::size_t refused = 0;
    const std::vector<bool> marked =
        mark(indicators(d.cells, d.irradiance, std::sqrt(static_cast<double>(profiles_.bounds(1).core_squared()))),
             part, room, refused);
    counters_.skipped["cells_beyond_limit"] += refused;
    SurfaceCells fresh;
    for (std::size_t i = 0; i < d.cells.size(); ++i)
      if (marked[i]) fresh.resize(fresh.size() + 4), split_in_four(d.cells[i], &fresh[fresh.size() - 4]);
    if (fresh.empty()) return false;
    const IrradianceField lit = object_irradiance(scene_, rays_, object_, fresh, d.cells.size(), light_, counters_);
    counters_.done["cells_added_by_discretisation"] += 3 * fresh.size() / 4;
    weave(d, marked, fresh, lit);
    return true;
  }

  /// Puts the new cells where their parents were.
  static void weave(Discretisation& d, const std::vector<bool>& marked, const SurfaceCells& fresh,
                    const IrradianceField& lit) {
    const auto width = static_cast<std::size_t>(lit.width());
    SurfaceCells cells;
    cells.reserve(d.cells.size() + 3 * fresh.size() / 4);
    IrradianceField field{lit.etas, lit.channels, lit.colour, {}, {}};
    const auto append = [&](const IrradianceField& from, std::size_t cell, std::size_t count) {
      const auto copy = [&](const std::vector<float>& source, std::vector<float>& target, std::size_t each) {
        const auto first = source.begin() + static_cast<std::ptrdiff_t>(cell * each);
        target.insert(target.end(), first, first + static_cast<std::ptrdiff_t>(count * each));
      };
      copy(from.values, field.values, width);
      copy(from.quarters, field.quarters, 4 * width);
    };
    std::size_t next = 0;
    for (std::size_t i = 0; i < d.cells.size(); ++i) {
      if (!marked[i]) {
        cells.push_back(d.cells[i]);
        append(d.irradiance, i, 1);
        continue;
      }
      cells.insert(cells.end(), &fresh[next], &fresh[next] + 4);
      append(lit, next, 4);
      next += 4;
    }
    d.cells = std::move(cells);
    d.irradiance = std::move(field);
  }

  const Scene& scene_;
  const RayScene& rays_;
  std::size_t object_;
  const ChannelProfiles& profiles_;
  const IrradianceSettings& light_;
  DiscretisationSettings settings_;
  Counters& counters_;
  bool lit_again_ = false;  ///< since the tree was built
  Discretisation fine_{};
};

}  // namespace

Discretisation discretise(const Scene& scene, const RayScene& rays, std::size_t object, const SurfaceCells& cells,
                          const IrradianceField& irradiance, const ChannelProfiles& profiles,
                          const IrradianceSettings& light, const DiscretisationSettings& settings, Counters& counters) {
  OPALINE_CHECK(irradiance.quarters.size() == 4 * irradiance.values.size());
  return Discretiser(scene, rays, object, profiles, light, settings, counters).run(cells, irradiance);
}

}  // namespace opaline
