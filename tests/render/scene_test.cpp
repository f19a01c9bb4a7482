#include "render/scene/scene.h"

#include "tests/render/scene_fixture.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace opaline {
namespace {

using nlohmann::json;
using test::document_with;
using test::document_without;
using test::message_of;
using test::TempFolder;
using test::valid_document;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

Scene parse(const json& document) { return parse_scene(document, "dir/s.json", test::test_shapes()); }

std::string error(const json& document) {
  const std::string message = message_of([&] { parse(document); });
  EXPECT_THAT(message, StartsWith("dir/s.json: "));
  return message.substr(std::min<std::size_t>(message.size(), 12));
}

std::string error_with(const std::string& pointer, const json& value) { return error(document_with(pointer, value)); }

TEST(Scene, ReadsTheValidDocument) {
  const Scene scene = parse(valid_document());
  EXPECT_EQ(scene.path, "dir/s.json");
  EXPECT_EQ(scene.film.width, 256);
  EXPECT_EQ(scene.film.height, 128);
  EXPECT_EQ(scene.camera.position, glm::dvec3(0, 0, 60));
  EXPECT_EQ(scene.camera.fov_y_deg, 25);
  const auto& sun = std::get<DirectionalLight>(scene.lights.at(0));
  EXPECT_EQ(sun.direction, glm::dvec3(0, 0, -1));  // normalised
  EXPECT_EQ(sun.irradiance, Rgb(3.14, 3, 2));
  const Material& material = scene.materials.at(0);
  EXPECT_EQ(material.name, "m1");
  EXPECT_EQ(material.g, 0.25);
  EXPECT_EQ(material.channel(1).sigma_a, 0.17);
  EXPECT_EQ(material.channel(2).sigma_s_prime, 1.01);
  EXPECT_EQ(scene.objects.at(0).name, "sphere");
  EXPECT_EQ(scene.objects.at(0).mesh.positions[2], glm::vec3(0, 5, 0));
  EXPECT_EQ(scene.dropped_triangles, 0u);
}

TEST(Scene, LengthsBecomeMillimetresAndNothingElse) {
  json document = valid_document();
  document["mm_per_unit"] = 10;
  document["camera"] =
      json::parse(R"({"type": "orthographic", "position": [0,0,6], "look_at": [0,1,0], "up": [0,3,0], "height": 2})");
  document["lights"] = json::parse(R"([
      {"type": "point", "position": [0,0,3], "intensity": 7},
      {"type": "projector", "position": [0,0,4], "look_at": [1,0,0], "intensity": 5, "disk_radius_deg": 2},
      {"type": "directional", "direction": [1,0,0], "irradiance": 2, "angular_radius_deg": 4}])");
  document["objects"][0]["transform"] = json::parse(R"({"translate": [1, 0, 0], "scale": 2})");
  const Scene scene = parse(document);
  EXPECT_EQ(scene.camera.type, Camera::Type::orthographic);
  EXPECT_EQ(scene.camera.position, glm::dvec3(0, 0, 60));
  EXPECT_EQ(scene.camera.look_at, glm::dvec3(0, 10, 0));
  EXPECT_EQ(scene.camera.height, 20);
  EXPECT_EQ(std::get<PointLight>(scene.lights[0]).position, glm::dvec3(0, 0, 30));
  EXPECT_EQ(std::get<PointLight>(scene.lights[0]).intensity, Rgb(7));
  const auto& projector = std::get<ProjectorLight>(scene.lights[1]);
  EXPECT_EQ(projector.position, glm::dvec3(0, 0, 40));
  EXPECT_EQ(projector.look_at, glm::dvec3(10, 0, 0));
  EXPECT_EQ(projector.disk_radius_deg, 2);
  EXPECT_EQ(projector.image, nullptr);
  EXPECT_EQ(std::get<DirectionalLight>(scene.lights[2]).irradiance, Rgb(2));
  EXPECT_EQ(scene.objects[0].mesh.positions[0], glm::vec3((5 * 2 + 1) * 10, 0, 0));
  EXPECT_EQ(scene.materials[0].sigma_a, Rgb(0.032, 0.17, 0.48));
}

// +x turned by 90 degrees about z is +y; about x first, then z: +y -> +z stays, and so on.
TEST(Scene, TransformScalesThenRotatesXYZThenTranslates) {
  json document = valid_document();
  document["objects"][0]["transform"] =
      json::parse(R"({"translate": [0, 0, 100], "rotate_deg": [90, 0, 90], "scale": [1, 2, 3]})");
  const Mesh mesh = parse(document).objects[0].mesh;
  const auto expect_at = [&](int vertex, const glm::vec3& position, const glm::vec3& normal) {
    EXPECT_NEAR(glm::distance(mesh.positions[static_cast<std::size_t>(vertex)], position), 0, 1e-4) << vertex;
    EXPECT_NEAR(glm::distance(mesh.normals[static_cast<std::size_t>(vertex)], normal), 0, 1e-6) << vertex;
  };
  expect_at(0, {0, 5, 100}, {0, 1, 0});   // +x -> +x -> +y
  expect_at(2, {0, 0, 110}, {0, 0, 1});   // +y -> +z -> +z
  expect_at(4, {15, 0, 100}, {1, 0, 0});  // +z -> -y -> +x
  document["objects"][0]["transform"] = json::parse(R"({"rotate_deg": [0, 90, 0]})");
  EXPECT_NEAR(glm::distance(parse(document).objects[0].mesh.positions[0], glm::vec3(0, 0, -5)), 0, 1e-5);
}

TEST(Scene, NormalsStayPerpendicularUnderUnequalScale) {
  json document = valid_document();
  document["objects"][0]["transform"] = json::parse(R"({"scale": [1, 2, 3], "rotate_deg": [10, 20, 30]})");
  const auto with_diagonal_normal = [](JsonObject&) {
    const glm::vec3 n = glm::normalize(glm::vec3(1, 1, 1));
    return Mesh{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {n, n, n}, {}, {{0, 1, 2}}};
  };
  document["objects"][0].erase("radius");
  const Mesh mesh = parse_scene(document, "s.json", {{"sphere", {"", with_diagonal_normal}}}).objects[0].mesh;
  const glm::vec3 a = mesh.positions[0], b = mesh.positions[1], c = mesh.positions[2];
  EXPECT_NEAR(glm::distance(mesh.normals[0], glm::normalize(glm::cross(b - a, c - a))), 0, 1e-6);
}

TEST(Scene, FormatAndVersionAreChecked) {
  EXPECT_EQ(error_with("/format", "other"), "/format: must be \"opaline-scene\", but is \"other\"");
  EXPECT_EQ(error_with("/version", 2), "/version: must be an integer from 1 to 1, but is 2");
  EXPECT_THAT(error_with("/mm_per_unit", 0), StartsWith("/mm_per_unit: must be a number > 0"));
}

TEST(Scene, EveryRequiredKeyIsMissed) {
  for (const char* pointer : {"/format",
                              "/version",
                              "/mm_per_unit",
                              "/film",
                              "/film/width",
                              "/film/height",
                              "/camera",
                              "/camera/type",
                              "/camera/position",
                              "/camera/look_at",
                              "/camera/fov_y_deg",
                              "/lights",
                              "/lights/0/type",
                              "/lights/0/direction",
                              "/lights/0/irradiance",
                              "/materials/m1/sigma_a_per_mm",
                              "/materials/m1/sigma_s_prime_per_mm",
                              "/materials/m1/eta",
                              "/objects",
                              "/objects/0/material",
                              "/objects/0/radius"}) {
    const json::json_pointer place(pointer);
    const std::string parent = place.parent_pointer().to_string();
    EXPECT_EQ(error(document_without(pointer)),
              (parent.empty() ? "" : parent + ": ") + "the key \"" + place.back() + "\" is missing");
  }
}

TEST(Scene, UnknownKeysAreErrorsEverywhere) {
  for (const char* place : {"", "/film", "/camera", "/lights/0", "/materials/m1", "/objects/0"}) {
    EXPECT_THAT(error_with(std::string(place) + "/zzzzzz", 1),
                AllOf(HasSubstr("unknown key \"zzzzzz\""), HasSubstr("valid keys: ")))
        << place;
  }
  EXPECT_THAT(error_with("/objects/0/transform", {{"rotate", {0, 0, 0}}}),
              EndsWith("/objects/0/transform: unknown key \"rotate\"; valid keys: translate, rotate_deg, scale"));
  EXPECT_THAT(error_with("/objects/0/zero_area_triangle", "drop"), HasSubstr("did you mean \"zero_area_triangles\"?"));
  EXPECT_THAT(error_with("/camera/height", 3), HasSubstr("/camera: unknown key \"height\""));  // not perspective's
}

TEST(Scene, UnknownNamesListTheValidOnes) {
  EXPECT_EQ(error_with("/camera/type", "perspektive"),
            "/camera/type: unknown choice \"perspektive\"; did you mean \"perspective\"? valid choices: perspective, "
            "orthographic");
  EXPECT_THAT(error_with("/lights/0/type", "spot"),
              EndsWith("valid choices: directional, point, environment, projector"));
  EXPECT_EQ(error_with("/objects/0/shape", "cube"),
            "/objects/0/shape: unknown shape \"cube\"; valid shapes: slab, sphere");
  EXPECT_THAT(error_with("/objects/0/shape", "spher"), HasSubstr("did you mean \"sphere\"?"));
  EXPECT_THAT(error_with("/objects/0/material", "skin"),
              AllOf(StartsWith("/objects/0/material: unknown material \"skin\"; did you mean \"Skin1\"?"),
                    HasSubstr("materials of the scene: m1;"), HasSubstr("Wholemilk")));
  EXPECT_THAT(error_with("/materials/m1/library", "hole milk"), HasSubstr("unknown library material \"hole milk\""));
  EXPECT_THAT(error_with("/objects/0/zero_area_triangles", "keep"), EndsWith("valid choices: reject, drop"));
}

TEST(Scene, FilmIsBounded) {
  for (const json& bad : {json(0), json(16385), json(1.5), json("256"), json(-4), json(1e300)}) {
    EXPECT_THAT(error_with("/film/width", bad), StartsWith("/film/width: must be an integer from 1 to 16384")) << bad;
  }
  EXPECT_EQ(parse(document_with("/film/width", 16384)).film.width, 16384);
}

TEST(Scene, CameraMustSeeSomewhere) {
  EXPECT_EQ(error_with("/camera/look_at", {0, 0, 60}), "/camera/look_at: must differ from \"position\"");
  EXPECT_THAT(error_with("/camera/up", {0, 0, 2}), StartsWith("/camera/up: must not be parallel"));
  EXPECT_THAT(error_with("/camera/up", {0, 0, 0}), StartsWith("/camera/up: must not be the zero vector"));
  for (double fov : {0.0, 180.0, -20.0}) {
    EXPECT_THAT(error_with("/camera/fov_y_deg", fov), StartsWith("/camera/fov_y_deg: must be a number > 0 and < 180"));
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_with("/camera/position", {0, nan, 1}),
            "/camera/position/1: must be a finite number, but is not finite");
}

TEST(Scene, LightsAreChecked) {
  EXPECT_EQ(error_with("/lights", json::array()), "/lights: needs at least one light, or every image is black");
  EXPECT_EQ(error_with("/lights/0/direction", {0, 0, 0}), "/lights/0/direction: must not be the zero vector");
  EXPECT_EQ(error_with("/lights/0/irradiance", {1, -1, 1}), "/lights/0/irradiance/1: must be a number >= 0, but is -1");
  EXPECT_THAT(error_with("/lights/0/angular_radius_deg", 91), HasSubstr("must be a number >= 0 and <= 90"));
  const json projector =
      json::parse(R"({"type": "projector", "position": [0,0,4], "look_at": [0,0,0], "intensity": 5})");
  EXPECT_EQ(error_with("/lights/0", projector), "/lights/0: needs exactly one of \"image\" and \"disk_radius_deg\"");
  json parallel = projector;
  parallel["disk_radius_deg"] = 1;
  parallel["up"] = {0, 0, 1};
  EXPECT_THAT(error_with("/lights/0", parallel), StartsWith("/lights/0/up: must not be parallel"));
}

TEST(Scene, LightImagesAreReadAndChecked) {
  TempFolder folder;
  const auto load = [&](const json& light) {
    return parse_scene(document_with("/lights/0", light), folder.file("s.json"), test::test_shapes());
  };
  Image sky(4, 2, {"R", "G", "B"});
  sky.at(3, 1, 2) = 7;
  write_exr(folder.file("sky.exr"), sky);
  const auto light =
      std::get<EnvironmentLight>(load({{"type", "environment"}, {"image", "sky.exr"}, {"scale", 2}}).lights[0]);
  EXPECT_EQ(light.path, folder.file("sky.exr"));
  EXPECT_EQ(light.image->at(3, 1, 2), 7);
  EXPECT_EQ(light.scale, Rgb(2));
  const auto bad = [&](const char* image) {
    return message_of([&] { load({{"type", "environment"}, {"image", image}}); });
  };
  EXPECT_EQ(bad("no.exr"),
            folder.file("s.json") + ": /lights/0/image: " + folder.file("no.exr") + ": the file does not exist");
  sky.at(0, 0, 0) = std::numeric_limits<float>::quiet_NaN();
  write_exr(folder.file("nan.exr"), sky);
  EXPECT_THAT(bad("nan.exr"), HasSubstr("1 of its values are NaN or infinite"));
  write_exr(folder.file("two.exr"), Image(2, 2, {"u", "v"}));
  EXPECT_THAT(bad("two.exr"), HasSubstr("needs the channels R, G and B"));
}

TEST(Scene, MaterialsAreChecked) {
  EXPECT_EQ(error_with("/materials/m1/sigma_a_per_mm", {-0.1, 0, 0}),
            "/materials/m1/sigma_a_per_mm/0: must be a number >= 0, but is -0.1");
  EXPECT_THAT(error_with("/materials/m1/sigma_s_prime_per_mm", -1), HasSubstr("must be a number >= 0, but is -1"));
  for (double eta : {0.0, -1.3})
    EXPECT_THAT(error_with("/materials/m1/eta", eta), StartsWith("/materials/m1/eta: must be a number > 0"));
  for (double g : {-1.0, 1.0})
    EXPECT_THAT(error_with("/materials/m1/g", g), HasSubstr("must be a number > -1 and < 1"));
  json clear = valid_document()["materials"]["m1"];
  clear["sigma_a_per_mm"] = clear["sigma_s_prime_per_mm"] = {1, 0, 1};
  EXPECT_THAT(
      error_with("/materials/m1", clear),
      AllOf(StartsWith("/materials/m1: sigma_a_per_mm + sigma_s_prime_per_mm must be > 0"), EndsWith("channel 1")));
  const Material grey = parse(document_with("/materials/m1/sigma_a_per_mm", 0.5)).materials[0];
  EXPECT_EQ(grey.sigma_a, Rgb(0.5));
}

// Jensen et al. 2001, figure 5: skin1 has sigma_a .032 .17 .48, sigma_s' .74 .88 1.01, eta 1.3.
TEST(Scene, LibraryMaterialsComeByNameAndAsABase) {
  json document = document_with("/objects/0/material", "SKIN1");
  document["objects"].push_back(document["objects"][0]);
  Scene scene = parse(document);
  ASSERT_EQ(scene.materials.size(), 2u);  // m1, and skin1 once for both objects
  EXPECT_EQ(scene.objects[0].material, 1);
  EXPECT_EQ(scene.objects[1].material, 1);
  EXPECT_EQ(scene.materials[1].sigma_a, Rgb(0.032, 0.17, 0.48));
  EXPECT_EQ(scene.materials[1].eta, 1.3);

  scene = parse(document_with("/materials/m1", {{"library", "skin1"}, {"eta", 1.4}, {"g", 0.9}}));
  EXPECT_EQ(scene.materials[0].name, "m1");
  EXPECT_EQ(scene.materials[0].sigma_s_prime, Rgb(0.74, 0.88, 1.01));
  EXPECT_EQ(scene.materials[0].eta, 1.4);
  EXPECT_EQ(scene.materials[0].g, 0.9);
}

TEST(Scene, ObjectsNeedExactlyOneSource) {
  EXPECT_EQ(error_with("/objects", json::array()), "/objects: needs at least one object");
  EXPECT_THAT(error_with("/objects/0/mesh", "a.obj"),
              AllOf(StartsWith("/objects/0: needs exactly one of"), EndsWith("both")));
  EXPECT_THAT(error(document_without("/objects/0/shape")), EndsWith("it has neither"));
  EXPECT_THAT(error_with("/objects/0/transform", {{"scale", 0}}), StartsWith("/objects/0/transform/scale: must be"));
  EXPECT_THAT(error_with("/objects/0/transform", {{"scale", 1e200}}),
              AllOf(StartsWith("/objects/0/shape: sphere: the position of "), HasSubstr("infinite")));
}

TEST(LoadScene, MeshesAreFoundBesideTheSceneAndErrorsNameBothFiles) {
  TempFolder folder;
  folder.write("t.obj", std::string(test::tetrahedron_obj) + "f 1 1 2\n");
  json document = valid_document();
  document["objects"][0] = {{"mesh", "t.obj"}, {"material", "m1"}, {"zero_area_triangles", "drop"}};
  const std::string path = folder.write("s.json", document.dump());
  const Scene scene = load_scene(path, test::test_shapes());
  EXPECT_EQ(scene.objects[0].mesh.triangles.size(), 4u);
  EXPECT_EQ(scene.dropped_triangles, 1u);

  const auto reload = [&] {
    folder.write("s.json", document.dump());
    return message_of([&] { load_scene(path, test::test_shapes()); });
  };
  document["objects"][0].erase("zero_area_triangles");
  EXPECT_EQ(reload(), path + ": /objects/0/mesh: " + folder.file("t.obj") +
                          ": 1 triangle (the first: 4, counted from 0) with zero area; mend the mesh, or set "
                          "\"zero_area_triangles\": \"drop\"");
  document["objects"][0]["mesh"] = "absent.obj";
  EXPECT_EQ(reload(), path + ": /objects/0/mesh: " + folder.file("absent.obj") + ": the file does not exist");
  document["objects"][0]["mesh"] = "";
  EXPECT_THAT(reload(), HasSubstr("unknown mesh format"));
}

}  // namespace
}  // namespace opaline
