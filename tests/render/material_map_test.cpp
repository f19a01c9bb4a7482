// Coefficients that vary over a surface: textures, coordinates, and what image-space sampling makes of them.
#include "render/scene/material_map.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "render/image_space/image_space.h"
#include "render/render_scene.h"
#include "render/scene/texture_coordinates.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/render_fixture.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

using testing::HasSubstr;

std::shared_ptr<const Image> grey_image(int width, int height, const std::vector<float>& rows) {
  Image image(width, height, {"Y"});
  image.data = rows;
  return std::make_shared<const Image>(image);
}

float value(const SurfaceTexture& texture, float u, float v) {
  float out = 0;
  texture.sample({u, v}, 1, &out);
  return out;
}

TEST(SurfaceTexture, HasItsLowerLeftCornerAtZeroAndFiltersBetweenTexelCentres) {
  SurfaceTexture texture{"", grey_image(2, 2, {1, 2, 3, 4}), SurfaceTexture::Wrap::clamp,
                         SurfaceTexture::Filter::bilinear};
  EXPECT_EQ(value(texture, 0.25f, 0.25f), 3) << "the bottom row is the last";
  EXPECT_EQ(value(texture, 0.75f, 0.75f), 2);
  EXPECT_EQ(value(texture, 0.5f, 0.25f), 3.5f);
  EXPECT_EQ(value(texture, 0.5f, 0.5f), 2.5f);
  EXPECT_EQ(value(texture, -3, 7), 1);
  texture.filter = SurfaceTexture::Filter::nearest;
  EXPECT_EQ(value(texture, 0.49f, 0.49f), 3);
  EXPECT_EQ(value(texture, 0.51f, 0.49f), 4);
}

TEST(SurfaceTexture, WrapsAsItSays) {
  SurfaceTexture texture{"", grey_image(4, 1, {1, 2, 3, 4}), SurfaceTexture::Wrap::repeat,
                         SurfaceTexture::Filter::nearest};
  EXPECT_EQ(value(texture, 1.1f, 0), 1);
  EXPECT_EQ(value(texture, -0.1f, 0), 4);
  texture.wrap = SurfaceTexture::Wrap::mirror;
  EXPECT_EQ(value(texture, 1.1f, 0), 4);
  EXPECT_EQ(value(texture, -0.1f, 0), 1);
  EXPECT_EQ(value(texture, -0.3f, 0), 2);
  EXPECT_EQ(value(texture, 2.1f, 0), 1);
  EXPECT_GT(value(texture, 1e30f, -1e30f), 0) << "far outside is finite";
}

// Each projection's coordinates, read back at points of triangles, agree with its formula there (to what a chord
// differs from an arc), across the seam and at the poles too.
TEST(TextureCoordinates, RunOnAcrossTheSeam) {
  Mesh mesh = make_sphere(10, 3000);
  const std::size_t before = mesh.positions.size();
  make_texture_coordinates(mesh, UvProjection::spherical);
  EXPECT_GT(mesh.positions.size(), before);
  EXPECT_LT(mesh.positions.size(), before + 200);
  EXPECT_EQ(validate_mesh(mesh, ZeroAreaTriangles::reject, "", ""), 0u);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3 k = mesh.triangles[t];
    const glm::vec3 p = (mesh.positions[k.x] + mesh.positions[k.y] + mesh.positions[k.z]) / 3.0f;
    if (std::hypot(p.x, p.z) < 2) continue;
    const glm::vec2 uv = uv_at(mesh, t, p);
    const double u = std::atan2(static_cast<double>(p.x), static_cast<double>(p.z)) / (2 * pi) + 0.5;
    EXPECT_NEAR(std::remainder(static_cast<double>(uv.x) - u, 1.0), 0, 4e-3);
    EXPECT_NEAR(static_cast<double>(uv.y), std::asin(static_cast<double>(p.y / glm::length(p))) / pi + 0.5, 2e-3);
  }
}

TEST(TextureCoordinates, OfAPlaneAreItsXAndY) {
  Mesh mesh = make_slab({20, 10, 2}, 200);
  make_texture_coordinates(mesh, UvProjection::planar);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_NEAR(mesh.uvs[i].x, mesh.positions[i].x / 20 + 0.5f, 1e-6);
    EXPECT_NEAR(mesh.uvs[i].y, mesh.positions[i].y / 10 + 0.5f, 1e-6);
  }
}

// --- scene files ------------------------------------------------------------------------------------

nlohmann::json mapped_document(const nlohmann::json& map) {
  return test::document_with("/materials/m1", {{"sigma_a_per_mm", map}, {"sigma_s_prime_per_mm", 1}, {"eta", 1.3}});
}

class MapFiles : public testing::Test {
 protected:
  MapFiles() {
    write_exr(folder.file("map.exr"), *grey_image(2, 1, {0.5f, 1}));
    write_exr(folder.file("negative.exr"), *grey_image(1, 1, {-1}));
    write_exr(folder.file("nan.exr"), *grey_image(1, 1, {std::nanf("")}));
    write_exr(folder.file("two.exr"), Image(1, 1, {"Y", "Z"}));
    folder.write("plain.obj", test::tetrahedron_obj);
    folder.write("textured.obj",
                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
                 "f 1/1 3/3 2/2\nf 1/1 2/2 4/3\nf 2/2 3/3 4/1\nf 1/1 4/3 3/2\n");
  }
  Scene load(const nlohmann::json& document) {
    return parse_scene(document, folder.file("scene.json"), test::test_shapes());
  }
  std::string message(const nlohmann::json& document) {
    return test::message_of([&] { load(document); });
  }
  test::TempFolder folder;
};

TEST_F(MapFiles, GiveACoefficientItsPlaces) {
  const Scene scene = load(mapped_document({{"image", "map.exr"}, {"scale", {1, 2, 4}}, {"filter", "nearest"}}));
  const Material& m = scene.materials[0];
  ASSERT_TRUE(m.textured());
  EXPECT_EQ(m.sigma_a, Rgb(0.75, 1.5, 3));
  EXPECT_EQ(m.at({0.25f, 0.5f}).sigma_a, Rgb(0.5, 1, 2));
  EXPECT_EQ(m.at({0.75f, 0.5f}).sigma_a, Rgb(1, 2, 4));
  EXPECT_EQ(m.at({0.75f, 0.5f}).sigma_s_prime, Rgb(1));
  EXPECT_EQ(scene.objects[0].mesh.uvs.size(), scene.objects[0].mesh.positions.size()) << "made for the shape";
}

TEST_F(MapFiles, OfMeshesNeedTheirCoordinates) {
  nlohmann::json document = mapped_document({{"image", "map.exr"}});
  document["objects"][0] = {{"mesh", "textured.obj"}, {"material", "m1"}};
  EXPECT_EQ(load(document).objects[0].mesh.uvs.size(), load(document).objects[0].mesh.positions.size());
  document["objects"][0]["mesh"] = "plain.obj";
  EXPECT_THAT(message(document), HasSubstr("plain.obj: has no texture coordinates, which material \"m1\" needs; add "
                                           "them to the mesh, or set \"texture_coordinates\""));
  document["objects"][0]["texture_coordinates"] = "spherical";
  EXPECT_FALSE(load(document).objects[0].mesh.uvs.empty());
}

TEST_F(MapFiles, AreRejectedWithOneReason) {
  EXPECT_THAT(message(mapped_document({{"image", "absent.exr"}})), HasSubstr("/materials/m1/sigma_a_per_mm/image"));
  EXPECT_THAT(message(mapped_document({{"image", "negative.exr"}})), HasSubstr("has values below 0"));
  EXPECT_THAT(message(mapped_document({{"image", "nan.exr"}})), HasSubstr("NaN or infinite"));
  EXPECT_THAT(message(mapped_document({{"image", "two.exr"}})), HasSubstr("channels R, G and B, or just one"));
  EXPECT_THAT(message(mapped_document({{"image", "map.exr"}, {"wrap", "tile"}})), HasSubstr("repeat, clamp, mirror"));
  EXPECT_THAT(message(mapped_document({{"image", "map.exr"}, {"tint", 1}})), HasSubstr("unknown key \"tint\""));
  nlohmann::json layered = mapped_document({{"image", "map.exr"}});
  for (const auto& [image, reason] :
       {std::pair("negative.exr", "has depths below 0"), std::pair("nan.exr", "NaN or")}) {
    layered["materials"]["m1"] = {
        {"layers",
         {{"depth_textures", {{{"image", image}}}}, {"media", {{{"sigma_s_per_mm", 1}, {"sigma_t_per_mm", 1}}}}}}};
    EXPECT_THAT(message(layered), testing::AllOf(HasSubstr("depth_textures/0/image: "), HasSubstr(reason)));
  }
  nlohmann::json nothing = mapped_document({{"image", "map.exr"}, {"scale", {0, 1, 1}}});
  nothing["materials"]["m1"]["sigma_s_prime_per_mm"] = {0, 1, 1};
  EXPECT_THAT(message(nothing), HasSubstr("must be > 0 and finite in each channel"));
}

// --- image-space sampling ---------------------------------------------------------------------------

const Technique& sampling() { return find_technique("image_space_sampling"); }

/// A slab of 60 mm, all of it lit from above, of which the camera sees 24.
Scene slab(Material material) {
  Mesh mesh = make_slab({60, 60, 12}, 400);
  make_texture_coordinates(mesh, UvProjection::planar);
  Scene scene = test::make_scene(std::move(mesh), std::move(material), 24, 32);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1), 0}};
  return scene;
}

Material with_map(Material material, std::shared_ptr<const Image> image, const Rgb& scale,
                  SurfaceTexture::Filter filter = SurfaceTexture::Filter::nearest) {
  auto map = std::make_shared<MaterialMap>();
  map->texture = {"", std::move(image), SurfaceTexture::Wrap::repeat, filter};
  map->scale = scale;
  material.sigma_a = map->mean();
  material.sigma_a_map = map;
  return material;
}

Frame render(const Scene& scene, const std::map<std::string, std::string>& given = {}) {
  const SharedScene shared(scene, {1, {}}, false);
  return sampling().prepare(shared, Settings(sampling().settings, given))->render(shared.view);
}

TEST(TexturedSampling, AConstantMapIsNoMap) {
  const Material skin = test::library_material("skin1");
  const Frame plain = render(slab(skin)), mapped = render(slab(with_map(skin, grey_image(1, 1, {1}), skin.sigma_a)));
  ASSERT_EQ(plain.exitance.size(), mapped.exitance.size());
  for (std::size_t i = 0; i < plain.exitance.size(); ++i)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(plain.exitance[i][c], mapped.exitance[i][c], 2e-6f);
  EXPECT_EQ(mapped.counters.done.at("points_with_own_profile"), 0u);
}

// The parameters at the shaded point decide the profile: a checker of two materials shows, at every pixel, what a
// slab of that pixel's material would.
TEST(TexturedSampling, ACheckerIsEachOfItsMaterialsAtEveryPixel) {
  Material a = test::library_material("skin1"), b = a;
  b.sigma_a = 4.0 * a.sigma_a;
  const Scene checker = slab(with_map(a, grey_image(2, 2, {1, 4, 4, 1}), a.sigma_a));
  const Frame mixed = render(checker), first = render(slab(a)), second = render(slab(b));
  const SharedScene shared(checker, {1, {}}, false);
  std::size_t of_a = 0;
  for (std::size_t i = 0; i < mixed.exitance.size(); ++i) {
    const glm::vec3 p = shared.view.points[i].position;
    const bool is_a = p.x * p.y < 0;
    of_a += is_a;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(mixed.exitance[i][c], (is_a ? first : second).exitance[i][c], 2e-6f) << p.x << " " << p.y;
  }
  EXPECT_GT(of_a, mixed.exitance.size() / 3);
  EXPECT_LT(of_a, mixed.exitance.size() * 2 / 3);
  EXPECT_EQ(mixed.counters.done.at("representative_materials"), 2u);
}

/// Absorption rising over x by a factor of 3, filtered: no two columns of pixels share a material.
Material ramp() {
  std::vector<float> row;
  for (int i = 0; i < 16; ++i) row.push_back(1 + static_cast<float>(i) / 7.5f);
  const Material skin = test::library_material("skin1");
  return with_map(skin, grey_image(16, 1, row), skin.sigma_a, SurfaceTexture::Filter::bilinear);
}

// Between the representatives each point has its own profile: under even light and normalised by the samples that met
// the slab it is that profile's total, to the noise of the samples.
TEST(TexturedSampling, APointHasTheProfileOfItsOwnMaterial) {
  const Scene scene = slab(ramp());
  const Frame frame = render(scene, {{"samples_per_pixel", "512"}});
  EXPECT_GT(frame.counters.done.at("points_with_own_profile"), frame.exitance.size() * 9 / 10);
  EXPECT_GT(frame.counters.done.at("representative_materials"), 2u);
  const SharedScene shared(scene, {1, {}}, false);
  for (std::size_t i = 0; i < frame.exitance.size(); ++i) {
    const VisiblePoint& p = shared.view.points[i];
    if (std::max(std::abs(p.position.x), std::abs(p.position.y)) > 4) continue;
    Scene own = slab(scene.materials[0].at(uv_at(scene.objects[0].mesh, p.triangle, p.position)));
    const Frame exact = render(own, {{"samples_per_pixel", "512"}});
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(frame.exitance[i][c], exact.exitance[i][c], 0.03f * exact.exitance[i][c]);
    if (i % 3 == 0) i += 160;  // a few places are enough
  }
}

TEST(TexturedSampling, TheTwinsAgree) {
  const auto context = test::context_or_null();
  if (!context) GTEST_SKIP() << test::no_gl;
  for (const char* profile : {"standard_dipole", "normalised_diffusion"})
    for (const bool sphere : {false, true}) {
      Scene scene = slab(ramp());
      if (sphere) {
        scene.objects[0].mesh = make_sphere(10, 500);
        make_texture_coordinates(scene.objects[0].mesh, UvProjection::spherical);
        scene.camera = {Camera::Type::perspective, {5, -30, 60}, {0, 0, 0}, {0, 1, 0}, 22, 0};
        scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(0.8, -0.3, -0.5)), Rgb(1, 0.5, 0.2), 0},
                        PointLight{{10, 20, 30}, Rgb(200, 300, 100)}};
      }
      const SharedScene shared(scene, {1, {}}, false);
      const Settings settings(sampling().settings, {{"profile", profile}});
      const Frame cpu = sampling().prepare(shared, settings)->render(shared.view);
      const Frame gpu = sampling().prepare_gpu(shared, settings, *context)->render(shared.view);
      double squares = 0, norm = 0;
      for (std::size_t i = 0; i < cpu.exitance.size(); ++i) {
        const glm::dvec3 a(cpu.exitance[i]), d = glm::dvec3(gpu.exitance[i]) - a;
        squares += glm::dot(d, d), norm += glm::dot(a, a);
      }
      EXPECT_LT(std::sqrt(squares / norm), sampling().twin_tolerance) << profile << (sphere ? ", sphere" : ", slab");
    }
}

TEST(TexturedMaterials, AreRefusedByWhatTakesOneCoefficient) {
  const Scene scene = slab(ramp());
  for (const Technique& technique : techniques()) {
    const auto& kinds = technique.materials;
    const bool takes = std::find(kinds.begin(), kinds.end(), MaterialKind::textured) != kinds.end();
    EXPECT_EQ(why_not_applicable(technique, scene).empty(), takes) << technique.name;
  }
  EXPECT_THAT(why_not_applicable(find_technique("hierarchical"), scene), HasSubstr("has maps"));
}

}  // namespace
}  // namespace opaline
