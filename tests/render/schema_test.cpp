// The published JSON Schema, the page scene.md and the loader must tell the same story.
#include "render/scene/scene.h"
#include "tests/render/scene_fixture.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <sstream>

#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

namespace opaline {
namespace {

using nlohmann::json;
using test::document_with;
using test::document_without;
using test::TempFolder;
using test::valid_document;

const std::string source_folder = std::string(OPALINE_SOURCE_DIR) + "/render/scene/";

const json& schema_document() {
  static const json document = read_json_file(source_folder + "scene.schema.json");
  return document;
}

bool schema_accepts(const json& document) {
  static const valijson::Schema& schema = [&]() -> const valijson::Schema& {
    static valijson::Schema parsed;
    valijson::SchemaParser(valijson::SchemaParser::kDraft7)
        .populateSchema(valijson::adapters::NlohmannJsonAdapter(schema_document()), parsed);
    return parsed;
  }();
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  return validator.validate(schema, valijson::adapters::NlohmannJsonAdapter(document), nullptr);
}

/// A folder with every file that the documents name.
const TempFolder& files() {
  static const TempFolder folder;
  static const bool written = [] {
    folder.write("bunny.obj", test::tetrahedron_obj);
    write_exr(folder.file("sky.exr"), Image(4, 2, {"R", "G", "B"}));
    write_exr(folder.file("stripes.exr"), Image(4, 2, {"Y"}));
    Image veins(4, 2, {"R", "G", "B"});
    veins.data.assign(veins.data.size(), 0.5f);
    write_png(folder.file("veins.png"), veins);
    return true;
  }();
  EXPECT_TRUE(written);
  return folder;
}

/// Empty when the loader accepts, else its message.
std::string loader_says(const json& document) {
  try {
    parse_scene(document, files().file("scene.json"), test::test_shapes());
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

std::vector<json> good_documents() {
  std::vector<json> documents = {valid_document(), document_without("/camera/up"), document_without("/materials/m1/g")};
  const auto with = [&](const std::string& pointer, const char* value) {
    documents.push_back(document_with(pointer, json::parse(value)));
  };
  with("/film/width", "16384");
  with("/mm_per_unit", "1e-3");
  with("/camera", R"({"type": "orthographic", "position": [0,0,6], "look_at": [0,1,0], "height": 2})");
  with("/lights/0/irradiance", "0");
  with("/lights/0/angular_radius_deg", "90");
  with("/lights/1", R"({"type": "point", "position": [0,0,3], "intensity": [1,2,0]})");
  with("/lights/0", R"({"type": "environment", "image": "sky.exr"})");
  with("/lights/0", R"({"type": "environment", "image": "sky.exr", "scale": [1,2,3]})");
  with("/lights/0", R"({"type": "projector", "position": [0,0,4], "look_at": [1,0,0], "intensity": 5,
                        "disk_radius_deg": 2})");
  with("/lights/0", R"({"type": "projector", "position": [0,0,4], "look_at": [1,0,0], "up": [0,1,0], "intensity": 5,
                        "fov_y_deg": 10, "image": "stripes.exr"})");
  with("/lights/0", R"({"type": "projector", "position": [0,0,4], "look_at": [1,0,0], "intensity": 5,
                        "fov_y_deg": 10, "disk_radius_deg": 2})");
  with("/materials/m1/sigma_a_per_mm", "0.1");
  with("/materials/m1", R"({"library": "skin1"})");
  with("/materials/m1",
       R"({"library": "skin1", "sigma_a_per_mm": [1,2,3], "sigma_s_prime_per_mm": 2, "g": 0.5, "eta": 1})");
  with("/objects/0", R"({"mesh": "bunny.obj", "material": "m1"})");
  with("/objects/0", R"({"mesh": "bunny.obj", "material": "wholemilk", "zero_area_triangles": "drop",
                         "transform": {"translate": [0,0,1], "rotate_deg": [1,2,3], "scale": [1,2,3]}})");
  with("/objects/0/transform", R"({"scale": 2})");
  with("/materials/m1", R"({"layers": {"depth_textures": [{"image": "veins.png"}],
                             "media": [{"sigma_s_per_mm": 1, "sigma_t_per_mm": [1,2,3]}]}})");
  with("/objects/0/texture_coordinates", R"("cylindrical")");
  with("/materials/m1/sigma_a_per_mm", R"({"image": "veins.png"})");
  with("/materials/m1/sigma_a_per_mm",
       R"({"image": "stripes.exr", "scale": [1,2,3], "wrap": "mirror", "filter": "nearest"})");
  json no_materials = document_without("/materials");
  no_materials["objects"][0]["material"] = "skin1";
  documents.push_back(no_materials);
  return documents;
}

/// Faults that the shape of the document shows.
std::vector<json> structurally_bad_documents() {
  std::vector<json> documents = {json::array(), json(3), json::object()};
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
                              "/objects/0/shape"}) {
    documents.push_back(document_without(pointer));
  }
  const auto with = [&](const std::string& pointer, const char* value) {
    documents.push_back(document_with(pointer, json::parse(value)));
  };
  for (const char* place : {"", "/film", "/camera", "/lights/0", "/materials/m1"}) {
    with(std::string(place) + "/zzz", "1");
  }
  with("/format", "\"pbrt\"");
  with("/version", "2");
  with("/version", "\"1\"");
  with("/mm_per_unit", "0");
  for (const char* bad : {"0", "16385", "1.5", "\"8\"", "null", "true"}) with("/film/width", bad);
  with("/camera/type", "\"fisheye\"");
  with("/camera/position", "[0,0]");
  with("/camera/position", "[0,0,0,0]");
  with("/camera/position", "[0,\"0\",0]");
  with("/camera/position", "5");
  with("/camera/fov_y_deg", "0");
  with("/camera/fov_y_deg", "180");
  with("/camera/height", "1");
  with("/camera", R"({"type": "orthographic", "position": [0,0,6], "look_at": [0,1,0], "height": 0})");
  with("/lights", "[]");
  with("/lights", "{}");
  with("/lights/0/type", "\"spot\"");
  with("/lights/0/irradiance", "-1");
  with("/lights/0/irradiance", "[1,-1,1]");
  with("/lights/0/irradiance", "[1,1]");
  with("/lights/0/angular_radius_deg", "-1");
  with("/lights/0/angular_radius_deg", "91");
  with("/lights/0", R"({"type": "point", "position": [0,0,3]})");
  with("/lights/0", R"({"type": "environment"})");
  with("/lights/0", R"({"type": "environment", "image": "sky.exr", "scale": -1})");
  const std::string projector = R"({"type": "projector", "position": [0,0,4], "look_at": [1,0,0], "intensity": 5)";
  with("/lights/0", (projector + "}").c_str());
  with("/lights/0", (projector + R"(, "image": "stripes.exr"})").c_str());
  with("/lights/0", (projector + R"(, "image": "stripes.exr", "fov_y_deg": 9, "disk_radius_deg": 2})").c_str());
  with("/lights/0", (projector + R"(, "disk_radius_deg": 0})").c_str());
  with("/lights/0", (projector + R"(, "disk_radius_deg": 90})").c_str());
  with("/materials", "[]");
  with("/materials/m1", "\"skin1\"");
  with("/materials/m1/sigma_a_per_mm", "[0,0,-1e-9]");
  with("/materials/m1/sigma_s_prime_per_mm", "-2");
  with("/materials/m1/eta", "0");
  with("/materials/m1/eta", "-1");
  with("/materials/m1/g", "1");
  with("/materials/m1/g", "-1");
  with("/materials/m1/library", "7");
  with("/objects", "[]");
  with("/objects/0/mesh", "\"bunny.obj\"");
  with("/objects/0", R"({"mesh": "bunny.obj", "material": "m1", "radius": 3})");
  with("/objects/0", R"({"mesh": 7, "material": "m1"})");
  with("/objects/0/material", "1");
  with("/objects/0/zero_area_triangles", "\"keep\"");
  with("/objects/0/transform", "[1,0,0]");
  with("/objects/0/transform", R"({"rotate": [1,0,0]})");
  with("/objects/0/transform", R"({"scale": 0})");
  with("/objects/0/transform", R"({"scale": [1,-1,1]})");
  with("/objects/0/transform", R"({"translate": 1})");
  return documents;
}

/// Faults that only the loader can see.
std::vector<json> otherwise_bad_documents() {
  return {document_with("/camera/look_at", {0, 0, 60}),
          document_with("/camera/up", {0, 0, 1}),
          document_with("/lights/0/direction", {0, 0, 0}),
          document_with("/objects/0/material", "no such"),
          document_with("/objects/0/shape", "no such"),
          document_with("/objects/0/radius", -1),
          document_with("/objects/0/radios", 1),
          document_with("/objects/0", {{"mesh", "absent.obj"}, {"material", "m1"}}),
          document_with("/lights/0", {{"type", "environment"}, {"image", "absent.exr"}}),
          document_with("/materials/m1/sigma_a_per_mm", {{"image", "absent.exr"}}),
          document_with("/materials/m1", json::parse(R"({"layers": {"depth_textures": [{"image": "veins.png"}],
                        "media": [{"sigma_s_per_mm": 2, "sigma_t_per_mm": 1}]}})")),
          document_with("/materials/m1", json::parse(R"({"layers": {"depth_textures": [{"image": "stripes.exr"}],
                        "media": [{"sigma_s_per_mm": 1, "sigma_t_per_mm": 1}, {"sigma_s_per_mm": 1, "sigma_t_per_mm": 1}]}})")),
          document_with("/materials/m1", {{"sigma_a_per_mm", 0}, {"sigma_s_prime_per_mm", 0}, {"eta", 1}})};
}

TEST(SceneSchema, AcceptsWhatTheLoaderAccepts) {
  for (const json& document : good_documents()) {
    EXPECT_TRUE(schema_accepts(document)) << document;
    EXPECT_EQ(loader_says(document), "") << document;
  }
}

TEST(SceneSchema, RejectsStructuralFaultsAsTheLoaderDoes) {
  for (const json& document : structurally_bad_documents()) {
    EXPECT_FALSE(schema_accepts(document)) << document;
    EXPECT_NE(loader_says(document), "") << document;
  }
}

TEST(SceneSchema, LoaderRejectsWhatASchemaCannotSee) {
  for (const json& document : otherwise_bad_documents()) {
    EXPECT_TRUE(schema_accepts(document)) << document;
    EXPECT_NE(loader_says(document), "") << document;
  }
}

void collect_properties(const json& node, std::set<std::string>& names) {
  if (node.is_object() && node.contains("properties")) {
    for (const auto& [name, value] : node["properties"].items()) names.insert(name);
  }
  for (const json& child : node) {
    if (child.is_structured()) collect_properties(child, names);
  }
}

std::string page() {
  std::ifstream in(source_folder + "scene.md");
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(ScenePage, MentionsEveryPropertyOfTheSchema) {
  std::set<std::string> names;
  collect_properties(schema_document(), names);
  EXPECT_GT(names.size(), 30u);
  const std::string text = page();
  for (const std::string& name : names) {
    EXPECT_NE(text.find("`" + name + "`"), std::string::npos) << name << " is not described";
    EXPECT_NE(text.find("\"" + name + "\":"), std::string::npos) << name << " stands in no example";
  }
}

/// The ```json blocks of the page.
std::vector<json> page_examples() {
  std::vector<json> examples;
  const std::string text = page(), open = "```json\n", close = "```";
  for (std::size_t at = text.find(open); at != std::string::npos; at = text.find(open, at)) {
    at += open.size();
    examples.push_back(json::parse(text.substr(at, text.find(close, at) - at)));
  }
  return examples;
}

/// Where an example belongs in the valid document.
json scene_of_example(const json& example) {
  if (example.contains("format")) return example;
  if (example.contains("mesh") || example.contains("shape")) return document_with("/objects/0", example);
  if (!example.contains("type")) return document_with("/materials/m1", example);
  const bool camera = example["type"] == "perspective" || example["type"] == "orthographic";
  return document_with(camera ? "/camera" : "/lights/0", example);
}

TEST(ScenePage, EveryExampleLoads) {
  std::set<std::string> types;
  for (const json& example : page_examples()) {
    const json document = scene_of_example(example);
    EXPECT_TRUE(schema_accepts(document)) << example;
    EXPECT_EQ(loader_says(document), "") << example;
    types.insert(example.value("type", example.contains("mesh") ? "mesh" : example.contains("shape") ? "shape" : ""));
  }
  const std::set<std::string> expected = {"",      "directional", "environment", "mesh", "orthographic", "perspective",
                                          "point", "projector",   "shape"};
  EXPECT_EQ(types, expected);
}

}  // namespace
}  // namespace opaline
