#include "model/transport/check.h"

#include "model/transport/h_function.h"
#include "model/transport/walk.h"

#include <cmath>
#include <cstdio>

namespace opaline {
namespace {

/// Numbers printed with five digits.
constexpr double rounding = 0.29e-5;

std::string labelled(const char* format, double a, double b = 0) {
  char text[96];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

struct Run {
  std::uint64_t walks, seed;
  std::vector<TransportCheckRow> rows;

  void compare(const std::string& name, double expected, double expected_error, const Estimate& reached) {
    rows.push_back({name, expected, expected_error, reached.value, reached.standard_error});
  }

  SearchlightResult slab(double albedo, double g, double thickness, double cosine) {
    WhiteWalk walk;
    walk.g = g;
    walk.optical_thickness = thickness;
    walk.cos_incident = cosine;
    walk.roulette_albedo = albedo;
    walk.walks = walks;
    walk.seed = seed++;
    return searchlight_at(white_walk(walk), albedo);
  }

  /// Slabs by van de Hulst 1980: the first from the MCML manual (Wang & Jacques 1992), the others from the tests of
  /// `iad` (Prahl).
  void van_de_hulst() {
    const struct {
      double albedo, g, thickness, cosine, reflected, transmitted;
    } table[] = {{.9, .75, 2, 1, .09739, .66096}, {.99, 0, 1, .5, .48652, .49163}, {.99, .5, 4, .5, .61996, .30605}};
    for (const auto& row : table) {
      const SearchlightResult r = slab(row.albedo, row.g, row.thickness, row.cosine);
      const std::string name = labelled("van de Hulst slab, g %g, thickness %g, ", row.g, row.thickness);
      compare(name + "reflected", row.reflected, rounding, r.reflected);
      compare(name + "transmitted", row.transmitted, rounding, r.transmitted);
    }
  }

  void half_space(double eta, double cosine) {
    WhiteWalk walk;
    walk.eta = eta;
    walk.cos_incident = cosine;
    walk.roulette_albedo = .99;
    walk.walks = walks;
    walk.seed = seed++;
    const WalkCounts counts = white_walk(walk);
    for (const double albedo : {.5, .9, .99}) {
      const std::string name = labelled("half space, eta %g, cosine %g, ", eta, cosine) + labelled("albedo %g", albedo);
      const double exact = half_space_albedo(albedo, eta, cosine).beam_per_transmitted;
      compare(name, exact, 1e-9, searchlight_at(counts, albedo).reflected);
    }
  }

  /// Half space of alpha' = .9 and eta = 1.3 for several g: totals by another program's Monte-Carlo walks.
  void phase_functions() {
    const struct { double g, reflected; } table[] = {{.5, .27940}, {.8, .27587}, {.9, .27526}, {-.3, .31116}};
    for (const auto& row : table) {
      Searchlight light{{.1, .9, 1.3}, row.g, 1, {}, walks, seed++};
      compare(labelled("half space, alpha' .9, eta 1.3, g %g", row.g), row.reflected, 1e-4,
              walk_half_space(light).reflected);
    }
  }
};

}  // namespace

double TransportCheckRow::z() const { return (reached - expected) / std::hypot(expected_error, standard_error); }

std::vector<TransportCheckRow> transport_check(std::uint64_t walks, std::uint64_t seed) {
  Run run{walks, seed, {}};
  run.van_de_hulst();
  for (const double eta : {1.0, 1.3, 1.4, 1.5, 0.8}) run.half_space(eta, 1);
  run.half_space(1, .5);
  run.half_space(1.5, .3);
  run.phase_functions();
  return run.rows;
}

}  // namespace opaline
