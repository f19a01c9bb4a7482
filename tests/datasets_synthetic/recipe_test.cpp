#include "datasets_synthetic/recipe.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "render/render_scene.h"
#include "tests/render/scene_fixture.h"

#include <gmock/gmock.h>

#include <filesystem>

namespace opaline {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

json valid_recipe() {
  return {{"format", "opaline-recipe"},
          {"version", 1},
          {"name", "mine"},
          {"summary", "a test"},
          {"scene", test::valid_document()},
          {"material", "m1"},
          {"noise", {{"relative", 0.02}}},
          {"seed", 7},
          {"starts", 3},
          {"samples", 500},
          {"technique", "hierarchical"},
          {"settings", {{"quality", 0.5}, {"criterion", "solid_angle"}}}};
}

std::string error_with(const std::string& pointer, const json& value) {
  json document = valid_recipe();
  document[json::json_pointer(pointer)] = value;
  return test::message_of([&] { parse_recipe(document, "r.json"); });
}

TEST(Recipe, IsReadWhole) {
  const Recipe r = parse_recipe(valid_recipe(), "folder/r.json");
  EXPECT_EQ(r.path, "folder/r.json");
  EXPECT_EQ(r.name, "mine");
  EXPECT_EQ(r.summary, "a test");
  EXPECT_EQ(r.scene, test::valid_document());
  EXPECT_EQ(r.material, "m1");
  EXPECT_EQ(r.noise_relative, 0.02);
  EXPECT_EQ(r.seed, 7u);
  EXPECT_EQ(r.starts, 3);
  EXPECT_EQ(r.samples, 500u);
  EXPECT_EQ(r.technique, "hierarchical");
  EXPECT_EQ(r.settings, (std::map<std::string, std::string>{{"quality", "0.5"}, {"criterion", "solid_angle"}}));
}

TEST(Recipe, NeedsEveryKeyButSettings) {
  const json whole = valid_recipe();
  for (const auto& [key, value] : whole.items()) {
    json document = whole;
    document.erase(key);
    if (key == "settings") {
      EXPECT_TRUE(parse_recipe(document, "r.json").settings.empty());
    } else {
      EXPECT_THAT(test::message_of([&] { parse_recipe(document, "r.json"); }), HasSubstr(key));
    }
  }
}

TEST(Recipe, NamesThePlaceOfWhatIsWrong) {
  EXPECT_THAT(error_with("/format", "opaline-scene"), HasSubstr("opaline-recipe"));
  EXPECT_THAT(error_with("/version", 2), HasSubstr("/version"));
  EXPECT_THAT(error_with("/nose", 1), HasSubstr("nose"));
  EXPECT_THAT(error_with("/noise/sd", 1), HasSubstr("sd"));
  EXPECT_THAT(error_with("/noise/relative", -0.1), HasSubstr("/noise/relative"));
  EXPECT_THAT(error_with("/name", "a/b"), HasSubstr("a/b"));
  EXPECT_THAT(error_with("/name", ""), HasSubstr("/name"));
  EXPECT_THAT(error_with("/seed", -1), HasSubstr("/seed"));
  EXPECT_THAT(error_with("/starts", 0), HasSubstr("/starts"));
  EXPECT_THAT(error_with("/samples", 0), HasSubstr("/samples"));
  EXPECT_THAT(error_with("/scene", "scene.json"), HasSubstr("/scene"));
  EXPECT_THAT(error_with("/settings", 3), HasSubstr("/settings"));
  EXPECT_THAT(error_with("/settings/quality", true), HasSubstr("quality"));
}

TEST(Recipe, IsFoundByNameOrFile) {
  const test::TempFolder folder;
  const std::string file = folder.write("other.json", valid_recipe().dump());
  EXPECT_EQ(find_recipe(file).name, "mine");
  EXPECT_EQ(find_recipe("bust_skin1").name, "bust_skin1");
  const std::string message = test::message_of([] { find_recipe("bust_skin"); });
  EXPECT_THAT(message, HasSubstr("did you mean \"bust_skin1\"?"));
  for (const Recipe& recipe : shipped_recipes()) EXPECT_THAT(message, HasSubstr(recipe.name));
}

TEST(ShippedRecipes, AreTheFilesOfTheFolder) {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(OPALINE_SOURCE_DIR "/datasets_synthetic/recipes")) {
    if (entry.path().extension() != ".json") continue;
    ++files;
    const Recipe from_file = load_recipe(entry.path().string()), built_in = find_recipe(entry.path().stem().string());
    EXPECT_EQ(from_file.name, entry.path().stem());
    EXPECT_EQ(from_file.scene, built_in.scene);
    EXPECT_EQ(from_file.seed, built_in.seed);
    EXPECT_EQ(from_file.noise_relative, built_in.noise_relative);
  }
  EXPECT_EQ(files, shipped_recipes().size());
  EXPECT_GE(files, 8u);
}

TEST(ShippedRecipes, AreReadyToRender) {
  for (const Recipe& recipe : shipped_recipes()) {
    SCOPED_TRACE(recipe.name);
    EXPECT_FALSE(recipe.summary.empty());
    EXPECT_TRUE(recipe.scene.at("materials").contains(recipe.material));
    for (const json& object : recipe.scene.at("objects")) {
      EXPECT_EQ(object.at("material"), recipe.material);
      EXPECT_TRUE(object.contains("shape")) << "a file would not be there";
    }
    RenderOptions options;
    options.technique = recipe.technique;
    options.settings = recipe.settings;
    EXPECT_NO_THROW(check_render_options(options));
    EXPECT_NO_THROW(parse_scene(recipe.scene, recipe.path, synthetic_shapes()));
  }
}

}  // namespace
}  // namespace opaline
