// The parts of the path tracer: refraction into flat facets, the search for them, the check of meshes.
#include "datasets_synthetic/shapes/shapes.h"
#include "model/fresnel.h"
#include "render/path_tracing/interior.h"
#include "render/path_tracing/path_weights.h"
#include "render/path_tracing/random.h"
#include "tests/support/render_fixture.h"

#include <gmock/gmock.h>

#include <map>
#include <numeric>
#include <set>

namespace opaline {
namespace {

using glm::dvec3;
using testing::HasSubstr;

/// A large facet in the plane z = 0.
Facet ground() { return {{-1000, -1000, 0}, {3000, 0, 0}, {0, 3000, 0}, {0, 0, 1}}; }

TEST(RefractedRay, ObeysSnellAndTheFresnelFlux) {
  for (const double eta : {0.8, 1.0, 1.33, 2.0})
    for (const PointOrDirection& light :
         {PointOrDirection{true, glm::normalize(dvec3(0.3, -0.5, 1))}, PointOrDirection{false, dvec3(3, -2, 4)}}) {
      const dvec3 y(0.5, 0.2, -1.5);
      const auto ray = refracted_ray(ground(), light, y, eta);
      ASSERT_TRUE(ray) << eta;
      EXPECT_NEAR(glm::length(ray->u), 1, 1e-14);
      EXPECT_NEAR(glm::length(ray->l), 1, 1e-14);
      EXPECT_NEAR(glm::length(y + ray->length * ray->u - ray->point), 0, 1e-12);
      EXPECT_NEAR(ray->point.z, 0, 1e-12);
      const dvec3 n(0, 0, 1), tangent_in = ray->u - ray->u.z * n, tangent_out = ray->l - ray->l.z * n;
      EXPECT_NEAR(glm::length(eta * tangent_in - tangent_out), 0, 1e-11) << eta;
      if (light.far) {
        EXPECT_NEAR(ray->irradiance, fresnel_transmittance(ray->l.z, eta) * ray->l.z / ray->u.z, 1e-12);
      }
    }
}

// Flux is conserved: a thin pencil of rays from the lamp covers, at y, the area its solid angle and the irradiance say.
TEST(RefractedRay, IrradianceOfANearLampIsTheWidthOfItsPencil) {
  const PointOrDirection light{false, dvec3(3, -2, 4)};
  for (const double eta : {0.8, 1.0, 1.5}) {
    const dvec3 y(0.5, 0.2, -1.5);
    const auto ray = refracted_ray(ground(), light, y, eta);
    ASSERT_TRUE(ray);
    const auto where = [&](const dvec3& from_lamp) {  // where a ray of the lamp meets the plane that faces y's ray
      const dvec3 point = light.place - light.place.z / from_lamp.z * from_lamp;
      const auto u = direction_inside(-from_lamp, {0, 0, 1}, eta);
      return point - *u * (glm::dot(point - y, ray->u) / glm::dot(*u, ray->u));
    };
    const dvec3 axis = -ray->l, s = glm::normalize(glm::cross(axis, dvec3(0, 0, 1))), t = glm::cross(axis, s);
    const double h = 1e-4;
    const auto slope = [&](const dvec3& d) {
      return (where(glm::normalize(axis + h * d)) - where(glm::normalize(axis - h * d))) / (2 * h);
    };
    const double area = glm::length(glm::cross(slope(s), slope(t)));
    EXPECT_NEAR(ray->irradiance * area / fresnel_transmittance(ray->l.z, eta), 1, 1e-6) << eta;
  }
  // Without a boundary it is one over the squared distance.
  const auto straight = refracted_ray(ground(), light, {0.5, 0.2, -1.5}, 1);
  EXPECT_NEAR(straight->irradiance * std::pow(glm::length(light.place - dvec3(0.5, 0.2, -1.5)), 2), 1, 1e-12);
}

TEST(RefractedRay, EdgesPartTheirFacetsWithoutGapOrOverlap) {
  const dvec3 n(0, 0, 1);
  const Facet lower{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, n}, upper{{0, 0, 0}, {1, 1, 0}, {0, 1, 0}, n};
  RandomStream random{7};
  for (int i = 0; i < 1000; ++i) {
    const double x = i % 2 ? random() : (i % 100) / 100.0 + 0.005;
    EXPECT_NE(lower.contains({x, x, 0}), upper.contains({x, x, 0})) << x;
  }
}

// --- the search -------------------------------------------------------------------------------------

TEST(FacetTree, FindsExactlyTheFacetsThatATestOfAllFinds) {
  RandomStream random{3};
  SearchCounts counts;
  std::size_t found = 0, facets = 0;
  for (const Mesh& mesh : {make_torus(3, 1, 1500), make_sphere(3, 700), make_slab({5, 4, 1}, 300)}) {
    const FacetTree tree(facets_of(mesh));
    for (int i = 0; i < 200; ++i) {
      const dvec3 y(6 * random() - 3, 6 * random() - 3, 2 * random() - 1.5);
      const double eta = std::array{0.7, 1.0, 1.3, 2.2}[random.bits() % 4];
      PointOrDirection light{true, direction_around({0, 0, 1}, 2 * random() - 1, random())};
      if (i % 2) light = {false, light.place * (2 + 10 * random())};
      if (i % 4 == 3) light.axis = -glm::normalize(light.place), light.half_angle = 0.2;
      const double reach = i % 3 ? 1e9 : 1.5;
      std::set<const Facet*> all, searched;
      for (const Facet& f : tree.facets())
        if (const auto ray = refracted_ray(f, light, y, eta); ray && ray->length <= reach) all.insert(&f);
      tree.for_each_ray(light, y, eta, reach, counts,
                        [&](const RefractedRay&, const Facet& f) { searched.insert(&f); });
      facets += tree.facets().size();
      if (light.half_angle < pi) {  // a projector may leave out what it doesn't light
        for (const Facet* f : all) {
          const bool lit = light.may_light(refracted_ray(*f, light, y, eta)->point, 0);
          EXPECT_TRUE(!lit || searched.count(f)) << i;
        }
        continue;
      }
      EXPECT_EQ(all, searched) << i << " eta " << eta;
      found += all.size();
    }
  }
  EXPECT_GT(found, 200u);
  EXPECT_LT(counts.facets, facets / 4) << "of which a quarter of the calls, eta < 1, tests every lit facet";
}

TEST(FacetTree, DrawsWithTheProbabilityItStates) {
  const FacetTree tree(facets_of(make_sphere(3, 80)));
  RandomStream random{8};
  std::vector<double> values(tree.facets().size());
  for (double& v : values) v = random() < 0.3 ? 0 : random();
  const std::vector<double> sums = tree.node_sums(values);
  EXPECT_NEAR(sums[0], std::accumulate(values.begin(), values.end(), 0.0), 1e-12);
  std::map<std::uint32_t, std::pair<int, double>> drawn;
  constexpr int n = 40000;
  for (int i = 0; i < n; ++i) {
    const FacetTree::Drawn d = tree.draw(values, sums, {3, 0, 0}, 0.5, random());
    EXPECT_GT(values[d.facet], 0);
    auto& [count, probability] = drawn[d.facet];
    EXPECT_DOUBLE_EQ(count ? probability : d.probability, d.probability);
    ++count;
    probability = d.probability;
  }
  double sum = 0, chi_squared = 0;
  for (const auto& [facet, entry] : drawn) {
    sum += entry.second;
    chi_squared += std::pow(entry.first - n * entry.second, 2) / (n * entry.second);
  }
  EXPECT_NEAR(sum, 1, 1e-3) << "all but the least probable were drawn";
  const auto degrees = static_cast<double>(drawn.size());
  EXPECT_LT(std::abs(chi_squared - degrees) / std::sqrt(2 * degrees), 4);
}

// --- meshes -----------------------------------------------------------------------------------------

TEST(ClosedMesh, AcceptsTheShapesAndNamesWhatIsWrong) {
  for (const Mesh& mesh : {make_sphere(1, 80), make_slab({2, 2, 1}, 50), make_torus(2, 1, 200), make_teapot(1, 3000)})
    EXPECT_EQ(closed_mesh_fault(mesh), "");
  Mesh open = make_slab({2, 2, 1}, 50);
  open.triangles.pop_back();
  EXPECT_THAT(closed_mesh_fault(open), HasSubstr("not closed (3 edges"));
  Mesh flipped = make_sphere(1, 80);
  std::swap(flipped.triangles[5].x, flipped.triangles[5].y);
  EXPECT_THAT(closed_mesh_fault(flipped), HasSubstr("not closed (3 edges"));
  for (glm::uvec3& t : flipped.triangles) std::swap(t.x, t.y);
  std::swap(flipped.triangles[5].x, flipped.triangles[5].y);
  EXPECT_THAT(closed_mesh_fault(flipped), HasSubstr("inside out"));
}

// --- the interior -----------------------------------------------------------------------------------

// Rays that start on a facet, also at its very edges, meet the far side and not the facet they start from.
TEST(Interior, RaysFromTheSurfaceMeetTheFarSide) {
  const Scene scene = test::make_scene(make_slab({4, 4, 1}, 40), test::library_material("skin1"), 5);
  const RayScene rays(scene);
  const Interior interior(scene, rays, 0);
  EXPECT_NEAR(interior.mean_chord(), 4 * 16.0 / (2 * 16 + 4 * 4), 1e-6);
  RayCounts counts;
  RandomStream random{5};
  for (int i = 0; i < 2000; ++i) {
    const bool on_edge = i % 4 == 0;
    const dvec3 from(on_edge ? 2.0 : 4 * random() - 2, 4 * random() - 2, 0);
    const dvec3 direction = direction_around({0, 0, -1}, random(), random());
    const auto hit = interior.boundary(from, direction, counts);
    if (on_edge && direction.x > 0 && !hit) continue;  // leaves the solid at once
    ASSERT_TRUE(hit) << i;
    const dvec3 at = from + hit->distance * direction;
    const double outside = std::max({std::abs(at.x) - 2, std::abs(at.y) - 2, at.z, -1 - at.z});
    EXPECT_NEAR(outside, 0, 1e-5) << i;
    EXPECT_GT(glm::dot(direction, interior.facet(hit->facet).normal), 0);
  }
}

// --- weights ----------------------------------------------------------------------------------------

TEST(PathWeights, EqualChannelsAreOneLead) {
  Material m;
  m.sigma_a = {0.1, 0.2, 0.1};
  m.sigma_s_prime = {1, 2, 1};
  m.g = 0.5;
  const PathChannels channels(m);
  EXPECT_EQ(channels.count, 2);
  EXPECT_EQ(channels.of, (std::array{0, 1, 0}));
  EXPECT_DOUBLE_EQ(channels.sigma_s[1], 4);
  EXPECT_DOUBLE_EQ(channels.sigma_t[0], 2.1);
  EXPECT_DOUBLE_EQ(channels.smallest_sigma_t, 2.1);
}

// f_c / (sum of p_h), written out for a path of two flights.
TEST(PathWeights, AreTheBalanceHeuristic) {
  Material m;
  m.sigma_a = {0.1, 0.2, 0.4};
  m.sigma_s_prime = {1, 0.5, 3};
  const PathChannels channels(m);
  const auto t = [&](int c) { return m.sigma_a[c] + m.sigma_s_prime[c]; };
  for (int lead = 0; lead < 3; ++lead) {
    PathWeights weights(channels, lead);
    weights.fly(0.7);
    weights.scatter();
    weights.fly(1.9);
    double sum = 0;
    for (int c = 0; c < 3; ++c) sum += t(c) * std::exp(-t(c) * 2.6);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(weights.over(0.3)[c], m.sigma_s_prime[c] * std::exp(-t(c) * 2.9) / sum, 1e-14);
    const Rgb now = weights.over(0);
    EXPECT_DOUBLE_EQ(weights.most(), std::max({now.r, now.g, now.b}));
  }
}

TEST(PathWeights, RouletteKeepsTheMean) {
  Material m;
  m.sigma_a = Rgb(0.9);
  m.sigma_s_prime = Rgb(0.1);
  const PathChannels channels(m);
  RandomStream random{9};
  double sum = 0, squares = 0;
  constexpr int n = 20000;
  for (int i = 0; i < n; ++i) {
    PathWeights weights(channels, 0);
    weights.fly(1);
    weights.scatter();
    const double x = weights.survives(random()) ? weights.most() : 0;
    sum += x, squares += x * x;
  }
  const double error = std::sqrt((squares / n - sum / n * sum / n) / n);
  EXPECT_GT(error, 0) << "this weight must play";
  EXPECT_LT(std::abs(sum / n - 0.1) / error, 4);
}

}  // namespace
}  // namespace opaline
