// The bound that comes with the gather's answer must hold against a quadrature that shares no code with it.
#include "datasets_synthetic/shapes/shapes.h"
#include "tests/support/exitance_oracle.h"
#include "tests/support/render_fixture.h"

namespace opaline {
namespace {

struct Pair {
  std::string name;
  Mesh mesh;
  Material material;
  std::string profile = "standard_dipole";
  /// Irradiance at a place of the object, by its centroid and its number.
  float (*light)(const glm::vec3& place, std::size_t cell) = nullptr;
  int channels = 1;
};

float side_light(const glm::vec3& p, std::size_t) { return std::max(0.0f, 0.4f * p.x + 0.8f * p.z + 1); }
float patchy_light(const glm::vec3&, std::size_t cell) {
  return std::max(0.0f, std::sin(static_cast<float>(cell)) + 0.5f);
}
float one_cell(const glm::vec3&, std::size_t cell) { return cell == 77 ? 2.0f : 0.0f; }
float one_spot(const glm::vec3& p, std::size_t) { return p.x > 0 && std::hypot(p.y, p.z) < 2 ? 1.0f : 0.0f; }

Material grey(double sigma_a, double sigma_s_prime) {
  Material material;
  material.sigma_a = {sigma_a, 3 * sigma_a, 10 * sigma_a};
  material.sigma_s_prime = Rgb(sigma_s_prime);
  material.eta = 1.3;
  return material;
}

std::vector<Pair> pairs() {
  const Mesh sphere = make_sphere(10, 1300), bust = make_bust(40, 2500), teapot = make_teapot(15, 2000),
             slab = make_slab({20, 20, 0.5}, 1200), torus = make_torus(8, 3, 1200);
  std::vector<Pair> all;
  for (const char* material : {"wholemilk", "skin1", "marble", "ketchup", "cream"})
    all.push_back({std::string("sphere of ") + material, sphere, test::library_material(material)});
  for (const char* material : {"wholemilk", "skin2"}) {
    all.push_back({std::string("bust of ") + material, bust, test::library_material(material)});
    all.push_back({std::string("teapot of ") + material, teapot, test::library_material(material)});
    all.push_back({std::string("thin slab of ") + material, slab, test::library_material(material)});
    all.push_back({std::string("torus of ") + material, torus, test::library_material(material)});
  }
  all.push_back({"0.1 mean free paths", make_sphere(0.1, 1300), grey(0.001, 1)});
  all.push_back({"1000 mean free paths", make_sphere(1000, 1300), grey(0.001, 1)});
  all.push_back({"one lit cell", sphere, test::library_material("wholemilk"), "standard_dipole", one_cell});
  all.push_back({"one lit spot", sphere, test::library_material("marble"), "standard_dipole", one_spot});
  all.push_back({"patchy light", torus, test::library_material("wholemilk"), "standard_dipole", patchy_light});
  for (const std::string& name : medium_profile_names())
    all.push_back({name, sphere, test::library_material("skin1"), name});
  all.push_back({"coloured light", bust, test::library_material("skin1"), "standard_dipole", nullptr, 3});
  all.push_back({"coloured patchy light", torus, test::library_material("marble"), "standard_dipole", patchy_light, 3});
  return all;
}

/// How bound and error compare at a few points of a pair.
struct Comparison {
  std::vector<double> bound_over_error, error, bound;
};

Comparison compare(const Pair& pair, const GatherSettings& settings) {
  const SurfaceCells cells = make_surface_cells(pair.mesh, 0);
  IrradianceField field{1, pair.channels, Rgb(1), {}};
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (int c = 0; c < pair.channels; ++c) {
      const float e = (pair.light ? pair.light : side_light)(cell_centroid(cells[i]), i);
      field.values.push_back(c == 0 ? e : e * (1 + 0.3f * std::sin(0.1f * static_cast<float>(c * i))));
    }
  const ClusterTree tree = build_cluster_tree(cells, field);
  const ChannelProfiles profiles(*find_profile(pair.profile), pair.material, 1.01 * diameter(pair.mesh));
  std::vector<glm::vec3> points, bound;
  for (std::size_t i = 0; i < 60; ++i) {
    const SurfaceCell& c = cells[i * cells.size() / 60];
    points.push_back(i % 3 == 0 ? c.a : 0.6f * c.a + 0.3f * c.b + 0.1f * c.c);
  }
  Counters counters;
  const std::vector<glm::vec3> got = gather_exitance(tree, cells, profiles, Rgb(1), points, settings, counters, &bound);
  EXPECT_EQ(counters.done["queries_over_tolerance"], 0u) << pair.name;
  const double floor = 1e-3 * static_cast<double>(test::mean_lit_irradiance(cells, field));
  Comparison result;
  for (std::size_t i = 0; i < points.size(); i += 12) {
    const int c = static_cast<int>(i / 12) % 3;
    const Profile& profile = profiles.profile(c);
    const double exact =
        test::exitance_oracle(cells, field, pair.channels == 1 ? 0 : c, profile, points[i], 1e-9 * profile.total());
    const double error = std::abs(static_cast<double>(got[i][c]) - exact), b = static_cast<double>(bound[i][c]);
    // The quadrature itself is good to about 1e-8.
    EXPECT_LE(error, b + 2e-8 * exact) << pair.name << " point " << i << " channel " << c;
    if (settings.criterion == GatherSettings::Criterion::bound) {
      EXPECT_LE(b, settings.max_relative_error * std::max(exact + b, floor) * 1.01) << pair.name << " point " << i;
    } else {
      EXPECT_LE(error, settings.max_relative_error * std::max(exact, floor)) << pair.name << " point " << i;
    }
    result.bound_over_error.push_back(b / std::max(error, 1e-8 * exact));
  }
  return result;
}

TEST(CertifiedBound, HoldsEverywhereAndIsNotFarOff) {
  std::vector<double> ratios;
  const std::vector<Pair> all = pairs();
  ASSERT_GE(all.size(), 20u);
  for (const Pair& pair : all) {
    const Comparison c = compare(pair, test::by_bound(1e-3));
    ratios.insert(ratios.end(), c.bound_over_error.begin(), c.bound_over_error.end());
  }
  std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
  const double median = ratios[ratios.size() / 2];
  EXPECT_LE(median, 100) << "the bound says too little";
  RecordProperty("median_bound_over_error", std::to_string(median));
}

TEST(CertifiedBound, HoldsForAnyTolerance) {
  for (const double tolerance : {1.0, 0.1, 1e-2, 1e-4}) {
    compare({"sphere", make_sphere(10, 1300), test::library_material("wholemilk")}, test::by_bound(tolerance));
    compare({"slab", make_slab({20, 20, 0.5}, 1200), test::library_material("skin1")}, test::by_bound(tolerance));
  }
}

// Accepting by the estimate, the bound still holds, and the error itself is what was asked for, pixel by pixel.
TEST(CertifiedBound, HoldsWhereTheEstimateDecides) {
  for (const Pair& pair : pairs()) compare(pair, test::by_error(1e-3));
}

}  // namespace
}  // namespace opaline
