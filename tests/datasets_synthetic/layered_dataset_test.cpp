// The synthetic scenes of layered materials, and the fish they need.
#include "datasets_synthetic/layered/layered_datasets.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "render/path_tracing/interior.h"
#include "render/techniques/technique.h"
#include "tests/render/scene_fixture.h"

namespace opaline {
namespace {

glm::dvec3 cross_of(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a(mesh.positions[t.x]);
  return glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a);
}

TEST(Fish, IsClosedAndItsNormalsAgreeWithItsTriangles) {
  for (const int triangles : {112, 4000, 40000}) {
    const Mesh fish = make_fish(60, triangles);
    EXPECT_EQ(closed_mesh_fault(fish), "") << triangles;
    EXPECT_GT(fish.triangles.size(), static_cast<std::size_t>(triangles) / 2);
    EXPECT_LT(fish.triangles.size(), static_cast<std::size_t>(triangles) * 2);
    std::size_t agree = 0;
    for (const glm::uvec3& t : fish.triangles) {
      const glm::dvec3 n = cross_of(fish, t);
      EXPECT_GT(glm::length(n), 0);
      for (int i = 0; i < 3; ++i) agree += glm::dot(n, glm::dvec3(fish.normals[t[i]])) > 0;
    }
    if (triangles >= 4000) {
      EXPECT_GT(agree, 3 * fish.triangles.size() * 98 / 100) << triangles;
    }
  }
}

TEST(Fish, HasTheLengthAndAThinTail) {
  const Mesh fish = make_fish(60, 40000);
  float lo = 1e9f, hi = -1e9f, tail = 0;
  for (const glm::vec3& p : fish.positions) {
    lo = std::min(lo, p.x), hi = std::max(hi, p.x);
    if (std::abs(p.x + 28) < 0.3f) tail = std::max(tail, 2 * p.z);
  }
  EXPECT_NEAR(lo, -30, 1e-4);
  EXPECT_NEAR(hi, 30, 1e-4);
  EXPECT_NEAR(tail, 0.016 * 60, 0.3);
}

TEST(LayeredDatasets, WriteScenesThatBothTechniquesRender) {
  for (const LayeredDataset& dataset : layered_datasets()) {
    const test::TempFolder folder;
    write_layered_dataset(dataset, folder.file(dataset.name));
    Scene scene = load_scene(folder.file(dataset.name + "/scene.json"), synthetic_shapes());
    for (const char* technique : {"subsurface_texture", "single_scatter_exact"})
      EXPECT_EQ(why_not_applicable(find_technique(technique), scene), "") << dataset.name;
    scene.film = {24, 18};
    const SharedScene shared(scene, {1, {}}, false);
    const Technique& technique = find_technique("subsurface_texture");
    const Frame frame = technique.prepare(shared, Settings(technique.settings, {}))->render(shared.view);
    ASSERT_GT(frame.radiance.size(), 40u) << dataset.name;
    std::size_t lit = 0;
    for (const glm::vec3& l : frame.radiance) lit += l.r > 0 && std::isfinite(l.r + l.g + l.b);
    EXPECT_GT(lit, frame.radiance.size() / 2) << dataset.name;
    EXPECT_EQ(frame.counters.skipped.at("empty_layers"), 0u);
  }
}

TEST(LayeredDatasets, HaveDepthsThatGrowAndVeinsInPlaces) {
  for (const LayeredDataset& dataset : layered_datasets()) {
    const Image depths = dataset.depths();
    const int vein = dataset.name == "fish_layers" ? 1 : 2;
    std::size_t with = 0;
    for (int y = 0; y < depths.height; ++y)
      for (int x = 0; x < depths.width; ++x) {
        for (int c = 1; c < depths.channel_count(); ++c) ASSERT_GE(depths.at(x, y, c), depths.at(x, y, c - 1));
        with += depths.at(x, y, vein) > depths.at(x, y, vein - 1);
      }
    EXPECT_GT(with, depths.pixel_count() / 50) << dataset.name;
    EXPECT_LT(with, depths.pixel_count() / 2) << dataset.name;
  }
}

}  // namespace
}  // namespace opaline
