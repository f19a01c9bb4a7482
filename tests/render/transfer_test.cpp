// The transfer table against sums written out here, and the lights that use it against the oracle.
#include "model/fresnel.h"
#include "model/profiles/standard_dipole.h"
#include "render/irradiance/entering_light.h"
#include "tests/render/scene_fixture.h"
#include "tests/render/transfer_fixture.h"

#include <gmock/gmock.h>

#include <numeric>

namespace opaline {
namespace {

using testing::HasSubstr;

// --- vertices ---------------------------------------------------------------------------------------

TEST(TransferVertices, AreasAddUpToTheSurface) {
  for (const Mesh& mesh : {make_teapot(10, 2000), make_slab({4, 5, 6}, 300), make_torus(3, 1, 500)})
    for (const int parts : {1, 3}) {
      const TransferVertices vertices(mesh, parts);
      EXPECT_EQ(vertices.triangles.size(), mesh.triangles.size() * static_cast<std::size_t>(parts * parts));
      const std::vector<double> areas = vertex_areas(vertices.positions, vertices.triangles);
      const double sum = std::accumulate(areas.begin(), areas.end(), 0.0);
      EXPECT_NEAR(sum / surface_area(mesh), 1, 1e-5);
      EXPECT_GT(*std::min_element(areas.begin(), areas.end()), 0);
    }
}

TEST(TransferVertices, SharesTheVerticesOnEdges) {
  const Mesh mesh = make_sphere(5, 80);  // closed: V = F/2 + 2
  for (const int parts : {1, 2, 5}) {
    const TransferVertices vertices(mesh, parts);
    EXPECT_EQ(vertices.size(), vertices.triangles.size() / 2 + 2);
  }
}

TEST(TransferVertices, FindsThePartOfATriangleThatHoldsAPoint) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  const Mesh mesh = make_torus(3, 1, 200);
  for (const int parts : {1, 2, 7}) {
    const TransferVertices vertices(mesh, parts);
    for (int i = 0; i < 500; ++i) {
      const auto triangle = static_cast<std::uint32_t>(random() % mesh.triangles.size());
      float u = uniform(random), v = uniform(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const glm::vec3 p = surface_point(mesh, triangle, u, v).position;
      const TransferVertices::Place place = vertices.at(mesh, triangle, p);
      glm::vec3 mean(0);
      for (int k = 0; k < 3; ++k) {
        EXPECT_GE(place.weight[k], -1e-4f);
        mean += place.weight[k] * vertices.positions[place.corner[k]];
      }
      EXPECT_LT(glm::length(mean - p), 1e-5f) << parts;
    }
  }
}

// --- the table --------------------------------------------------------------------------------------

Scene torus_scene(const std::string& material = "skin1") {
  return test::make_scene(make_torus(6, 2, 800), test::library_material(material), 18, 12);
}

/// Entering irradiance meant over the cells' quarters by the scene's own lights, each with its ray: not the table's
/// code.
IrradianceField scene_irradiance(const TransferElements& elements, const Scene& scene, const RayScene& rays) {
  const LightSampler lights(scene, 1);
  const std::vector<double> etas{scene.materials[0].eta};
  EnteringLight light{rays, lights, etas, 1};
  IrradianceField field = test::constant_irradiance(elements.cells.size(), 0);
  for (std::size_t i = 0; i < elements.cells.size(); ++i) {
    double e = 0;
    for (std::size_t k = 0; k < 4; ++k) light.add(elements.points[4 * i + k], 0, 0, 0.25, &e);
    field.values[i] = static_cast<float>(e);
  }
  return field;
}

TEST(TransferTable, IsTheSumOverAllCellsForEveryLight) {
  test::TableFixture f(torus_scene(), test::table_settings(40), 3000);
  const TransferElements elements = cell_elements(f.scene.objects[0].mesh, 3000);
  ASSERT_EQ(f.table.keys.size(), 40u);
  double worst = 0, mean = 0;
  for (const std::uint32_t node : {0u, 7u, 20u, 33u, 39u}) {
    Scene lit = f.scene;
    lit.lights = {DirectionalLight{-f.nodes.direction(node), Rgb(1), 0}};
    const IrradianceField field = scene_irradiance(elements, lit, f.shared.rays);
    const test::GatherFixture exact(elements.cells, field, f.material(), 1.01 * diameter(f.scene.objects[0].mesh));
    const std::vector<glm::vec3> b = exact.gather(f.vertices.positions, test::brute_force());
    for (int c = 0; c < 3; ++c) {
      std::vector<double> given, wanted;
      for (std::size_t v = 0; v < b.size(); ++v) {
        given.push_back(static_cast<double>(f.table.row(node * 3 + static_cast<std::size_t>(c))[v]));
        wanted.push_back(static_cast<double>(b[v][c]));
      }
      const double error = test::relative_rms(given, wanted);
      worst = std::max(worst, error), mean += error / 15;
    }
  }
  RecordProperty("mean", std::to_string(mean));
  EXPECT_LT(worst, 0.01);  // shadow edges: one ray stands for a cell's four
  EXPECT_LT(mean, 5e-3);
}

TEST(TransferTable, WithoutShadowsIsTheSumToTheGathersError) {
  Scene scene = test::make_scene(make_sphere(5, 720), test::library_material("skin1"), 11, 8);
  for (const double tolerance : {1e-2, 1e-3}) {
    TransferSettings settings = test::table_settings(20);
    settings.max_relative_error = tolerance;
    const test::TableFixture f(scene, settings, 3000);
    const TransferElements elements = cell_elements(scene.objects[0].mesh, 3000);
    for (const std::uint32_t node : {3u, 11u}) {
      scene.lights = {DirectionalLight{-f.nodes.direction(node), Rgb(1), 0}};
      const test::GatherFixture exact(elements.cells, scene_irradiance(elements, scene, f.shared.rays), f.material(),
                                      11);
      const std::vector<glm::vec3> b = exact.gather(f.vertices.positions, test::brute_force());
      std::vector<double> given, wanted;
      for (std::size_t v = 0; v < b.size(); ++v)
        for (int c = 0; c < 3; ++c) {
          given.push_back(static_cast<double>(f.table.row(node * 3 + static_cast<std::size_t>(c))[v]));
          wanted.push_back(static_cast<double>(b[v][c]));
        }
      EXPECT_LT(test::relative_rms(given, wanted), tolerance);
    }
  }
}

TEST(TransferTable, VectorsTimesTheLightAreTheScalars) {
  TransferSettings settings = test::table_settings(24);
  settings.max_relative_error = 1e-3;
  const test::TableFixture scalar(torus_scene(), settings, 2000);
  settings.form = TransferForm::vectors;
  const test::TableFixture vectors(torus_scene(), settings, 2000);
  ASSERT_EQ(vectors.table.keys.size(), 72u);
  std::vector<double> given, wanted;
  for (std::uint32_t node = 0; node < 24; ++node)
    for (std::size_t v = 0; v < scalar.table.vertices; ++v) {
      double q = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        q += scalar.nodes.direction(node)[static_cast<int>(axis)] *
             static_cast<double>(vectors.table.row((3 * node + axis) * 3)[v]);
      given.push_back(q), wanted.push_back(static_cast<double>(scalar.table.row(3 * node)[v]));
    }
  EXPECT_LT(test::relative_rms(given, wanted), 1e-5);  // the same patches: only rounding differs
}

// With discs: the own disc in closed form, by d^2 = r^2 + z^2,
// 2 pi int_0^rho R_d r dr = alpha'/2 sum over poles of (e^(-s z) - z/d(rho) e^(-s d(rho))),
// and every other vertex's element, a triangle of its area, as its 64 parts.
TEST(TransferTable, ADiscsOwnTermIsItsClosedForm) {
  Scene scene = test::make_scene(make_sphere(10, 720), test::library_material("skin1"), 22, 8);
  TransferSettings settings = test::table_settings(20);
  settings.discs = true, settings.max_relative_error = 1e-5;
  const test::TableFixture f(scene, settings, 1);
  const std::vector<double> areas = vertex_areas(f.vertices.positions, f.vertices.triangles);
  const auto profile = find_profile("standard_dipole")->make(f.material().channel(1));
  const double a = f.material().sigma_a[1], sp = f.material().sigma_s_prime[1], t = a + sp, s = std::sqrt(3 * a * t);
  const double zr = 1 / t, zv = zr + 4 * dipole_boundary_a(f.material().eta) / (3 * t), albedo = sp / t;
  const auto within = [&](double rho) {
    double sum = 0;
    for (const double z : {zr, zv}) {
      const double d = std::sqrt(rho * rho + z * z);
      sum += albedo / 2 * (std::exp(-s * z) - z / d * std::exp(-s * d));
    }
    return sum;
  };
  const auto part_sum = [&](const SurfaceCell& cell, const glm::vec3& at) {
    double sum = 0;
    SurfaceCell first[4], second[4], third[4];
    split_in_four(cell, first);
    for (const SurfaceCell& i : first) {
      split_in_four(i, second);
      for (const SurfaceCell& k : second) {
        split_in_four(k, third);
        for (const SurfaceCell& m : third)
          sum += profile->evaluate(static_cast<double>(glm::length(cell_centroid(m) - at))) / 64;
      }
    }
    return sum;
  };
  const TransferElements elements = disc_elements(f.vertices);
  const glm::dvec3 w = f.nodes.direction(3);
  std::vector<double> given, wanted, without;
  for (std::size_t v = 0; v < f.vertices.size(); ++v) {
    double sum = 0, own = 0;
    for (std::size_t i = 0; i < f.vertices.size(); ++i) {
      const double cosine = glm::dot(glm::dvec3(f.vertices.normals[i]), w);
      if (cosine <= 0) continue;
      const double e = fresnel_transmittance(std::min(cosine, 1.0), f.material().eta) * cosine;
      if (i == v) own = e * within(std::sqrt(areas[i] / pi));
      if (i != v) sum += e * areas[i] * part_sum(elements.cells[i], f.vertices.positions[v]);
    }
    given.push_back(static_cast<double>(f.table.row(3 * 3 + 1)[v]));
    wanted.push_back(sum + own), without.push_back(sum);
  }
  EXPECT_LT(test::relative_rms(given, wanted), 0.01);
  EXPECT_GT(test::relative_rms(without, wanted), 0.2) << "the term the paper leaves out";
}

// --- the lights -------------------------------------------------------------------------------------

Frame render(const SharedScene& shared, const std::map<std::string, std::string>& set = {},
             const std::string& name = "precomputed_transfer") {
  const Technique& technique = find_technique(name);
  return technique.prepare(shared, Settings(technique.settings, set))->render(shared.view);
}

double difference(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
  double squares = 0, norm = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    const glm::dvec3 y(b[i]), d = glm::dvec3(a[i]) - y;
    squares += glm::dot(d, d), norm += glm::dot(y, y);
  }
  return std::sqrt(squares / norm);
}

Scene soft_sphere() {
  Scene scene = test::make_scene(make_sphere(5, 1280), test::library_material("marble"), 11, 24);
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(0.5, -0.3, -0.8)), Rgb(1), 0}};
  return scene;
}

/// Error of a table against the sum over all cells.
double error_of(const Scene& scene, const std::map<std::string, std::string>& set) {
  const SharedScene shared(scene, {4000, {}});
  return difference(render(shared, set).exitance, render(shared, {}, "brute_force").exitance);
}

TEST(TransferLights, APointLightLiesBetweenDirectionsAndDistances) {
  Scene scene = soft_sphere();
  scene.lights = {PointLight{{6, 9, 14}, Rgb(300, 200, 100)}};
  const auto error = [&](const std::string& directions, const std::string& distances) {
    return error_of(scene, {{"directions", directions}, {"distances", distances}, {"subdivide", "4"}});
  };
  const double fine = error("20000", "64"), usual = error("800", "6"), one_level = error("800", "1");
  EXPECT_LT(fine, 5e-3);
  EXPECT_LT(usual, 0.02);
  EXPECT_GT(one_level, 4 * usual) << "as if it were far away";
  scene.lights = {PointLight{{1, 2, 6}, Rgb(1)}};
  EXPECT_THAT(transfer_not_applicable(scene), HasSubstr("/lights/0 is 6.403 mm from the middle of /objects/0"));
  scene.lights = {ProjectorLight{}};
  EXPECT_THAT(transfer_not_applicable(scene), HasSubstr("projector"));
}

TEST(TransferLights, AnEnvironmentIsASumOfDirections) {
  Scene scene = soft_sphere();
  Image sky(16, 8, {"R", "G", "B"});
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x)
      for (int c = 0; c < 3; ++c) sky.at(x, y, c) = y < 4 ? 1.0f + 0.5f * static_cast<float>(c) : x < 8 ? 0.5f : 0.1f;
  scene.lights = {EnvironmentLight{"", std::make_shared<const Image>(sky), Rgb(2)}};
  SharedScene shared(scene, {2000, {1024, 1}});
  const Frame oracle = render(shared, {}, "brute_force");
  for (const char* form : {"float", "harmonics"})
    EXPECT_LT(difference(render(shared, {{"form", form}, {"order", "4"}}).exitance, oracle.exitance), 0.015) << form;
}

TEST(TransferLights, OfManyLightsIsTheSumOfEach) {
  Scene scene = soft_sphere();
  const std::vector<Light> all = {DirectionalLight{glm::normalize(glm::dvec3(0.5, -0.3, -0.8)), Rgb(1, 0.5, 0.2), 0},
                                  DirectionalLight{glm::normalize(glm::dvec3(-1, 0.2, 0.1)), Rgb(0.2, 1, 2), 10},
                                  PointLight{{6, 9, 14}, Rgb(100, 200, 300)}};
  std::vector<glm::vec3> sum;
  for (const Light& light : all) {
    scene.lights = {light};
    const SharedScene shared(scene, {2000, {}}, false);
    const Frame one = render(shared);
    sum.resize(one.exitance.size(), glm::vec3(0));
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += one.exitance[i];
  }
  scene.lights = all;
  const SharedScene shared(scene, {2000, {}}, false);
  EXPECT_LT(difference(render(shared).exitance, sum), 1e-5);
}

// --- what is skipped --------------------------------------------------------------------------------

TEST(TransferSkips, ChangeNothing) {
  Scene scene = torus_scene("marble");
  scene.lights.push_back(PointLight{{3, 4, 20}, Rgb(300, 200, 100)});
  const SharedScene shared(scene, {1500, {}}, false);
  const std::map<std::string, std::string> few = {{"directions", "32"}, {"distances", "2"}};
  auto with = [&](const std::string& key, const std::string& value) {
    auto set = few;
    set[key] = value;
    return render(shared, set);
  };
  const Frame scene_only = render(shared, few), any = with("lights", "any"), fixed = with("view", "fixed");
  EXPECT_EQ(scene_only.exitance, any.exitance);
  EXPECT_LT(difference(fixed.exitance, scene_only.exitance), 1e-3);  // other groups of queries in the gather
  EXPECT_EQ(any.counters.skipped.at("light_nodes_no_light_needs"), 0u);
  EXPECT_EQ(any.counters.done.at("light_nodes"), 64u);
  EXPECT_EQ(scene_only.counters.done.at("light_nodes") + scene_only.counters.skipped.at("light_nodes_no_light_needs"),
            64u);
  EXPECT_LE(scene_only.counters.done.at("light_nodes"), 12u);
  const TransferVertices all(scene.objects[0].mesh, 1);
  EXPECT_EQ(fixed.counters.done.at("vertices") + fixed.counters.skipped.at("unseen_vertices"), all.size());
  EXPECT_GT(fixed.counters.skipped.at("unseen_vertices"), all.size() / 3);
}

TEST(TransferSkips, AFixedViewServesNoOther) {
  const Scene front = torus_scene();
  Scene side = front;
  side.camera.position = {150, 50, 10};
  const SharedScene a(front, {1000, {}}, false), b(side, {1000, {}}, false);
  const Technique& technique = find_technique("precomputed_transfer");
  const auto prepared = technique.prepare(a, Settings(technique.settings, {{"view", "fixed"}, {"directions", "32"}}));
  EXPECT_THAT(test::message_of([&] { prepared->render(b.view); }), HasSubstr("view=fixed"));
}

// It has no vertex then, whatever is kept of the others.
TEST(TransferSkips, AFixedViewMaySeeNothingOfAnObject) {
  Scene scene = torus_scene("marble");
  scene.objects.push_back(scene.objects[0]);
  for (glm::vec3& p : scene.objects[1].mesh.positions) p.x += 500;
  const SharedScene shared(scene, {1500, {}}, false);
  for (const char* form : {"float", "vector", "lloyd", "harmonics", "reference"}) {
    const Frame fixed = render(shared, {{"view", "fixed"}, {"form", form}, {"directions", "64"}}),
                any = render(shared, {{"form", form}, {"directions", "64"}});
    EXPECT_LT(difference(fixed.exitance, any.exitance), 0.02) << form;
  }
}

TEST(TransferSkips, EqualChannelsAreMadeOnce) {
  Material grey = test::library_material("skin1");
  grey.sigma_a = Rgb(0.1), grey.sigma_s_prime = Rgb(1);
  Scene scene = test::make_scene(make_sphere(5, 320), grey, 11, 12);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1, 2, 0.5), 0}};
  const SharedScene shared(scene, {1000, {}}, false);
  const Frame frame = render(shared);
  EXPECT_EQ(frame.counters.skipped.at("equal_profiles"), 2u);
  EXPECT_EQ(frame.counters.skipped.at("equal_channels"), 2u);
  for (const glm::vec3& b : frame.exitance) {
    EXPECT_FLOAT_EQ(b.y, 2 * b.x);
    EXPECT_FLOAT_EQ(b.z, 0.5f * b.x);
  }
}

TEST(TransferSkips, UnlitVerticesCostNothingAtRunTime) {
  Scene scene = test::make_scene(make_slab({30, 30, 90}, 24000), test::library_material("skin1"), 70, 12);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1), 0}};
  const SharedScene shared(scene, {12000, {}}, false);
  const Frame frame = render(shared, {{"max_relative_error", "3e-2"}});
  EXPECT_GT(frame.counters.skipped.at("unlit_vertex_rows"), 0u);
  EXPECT_GT(frame.counters.done.at("vertex_rows"), 0u);
}

}  // namespace
}  // namespace opaline
