// Suites: what is read, what is refused, and which cells come out.
#include "validate/suite.h"

#include "tests/validate/validate_fixture.h"

#include <gmock/gmock.h>

#include <set>

namespace opaline {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string refusal(const std::string& pointer, const json& value) {
  json suite = test::tiny_suite();
  suite[json::json_pointer(pointer)] = value;
  return test::message_of([&] { parse_suite(suite, "s.json"); });
}

TEST(Suite, RefusesWhatIsWrongAndSaysWhere) {
  EXPECT_THAT(refusal("/scens", 1), AllOf(HasSubstr("s.json"), HasSubstr("did you mean \"scenes\"")));
  EXPECT_THAT(refusal("/scenes/0/filn", 1), AllOf(HasSubstr("/scenes/0"), HasSubstr("film")));
  EXPECT_THAT(refusal("/techniques/0", "brut"), AllOf(HasSubstr("/techniques"), HasSubstr("brute_force")));
  EXPECT_THAT(refusal("/techniques", "some"), HasSubstr("all"));
  EXPECT_THAT(refusal("/backends/0", "tpu"), AllOf(HasSubstr("/backends"), HasSubstr("gpu")));
  EXPECT_THAT(refusal("/sweeps/hierarchica", json::array()), HasSubstr("did you mean \"hierarchical\""));
  EXPECT_THAT(refusal("/sweeps/hierarchical/0/max_error", 1), HasSubstr("max_relative_error"));
  EXPECT_THAT(refusal("/sweeps/hierarchical/0/max_relative_error", "2"), HasSubstr("'2' is not a number from"));
  EXPECT_THAT(refusal("/edits", {"camara"}), AllOf(HasSubstr("/edits"), HasSubstr("camera")));
  EXPECT_THAT(refusal("/samples", 0), HasSubstr("/samples"));
  EXPECT_THAT(refusal("/max_seconds", -1), HasSubstr("/max_seconds"));
  EXPECT_THAT(refusal("/truth", {{"path", 3}}), HasSubstr("\"paths\" is missing"));
  EXPECT_THAT(refusal("/truth", {{"paths", 3}, {"scenes", {"frnt"}}}), HasSubstr("did you mean \"front\""));
  EXPECT_THAT(refusal("/reference", {{"quality", "x"}}), HasSubstr("/reference"));
  EXPECT_THAT(refusal("/scenes/1/name", "front"), HasSubstr("two scenes"));
  EXPECT_THAT(refusal("/scenes/1/name", "a b"), HasSubstr("letters, digits"));
  EXPECT_THAT(refusal("/scenes/1/recipe", "bust_skin1"), HasSubstr("exactly one"));
  EXPECT_THAT(refusal("/scenes/0", {{"name", "a"}, {"recipe", "fish_layer"}}), HasSubstr("fish_layers"));
  EXPECT_THAT(refusal("/layered_reference", {{"paths", 3}}), HasSubstr("max_relative_error"));
  EXPECT_THAT(refusal("/scenes/0/materials/0", 3), HasSubstr("/scenes/0/materials"));
  EXPECT_THAT(refusal("/scenes/0/materials/1", "skin1"), HasSubstr("two materials"));
  EXPECT_THAT(refusal("/sweeps/hierarchical/0/max_relative_error", json::array()), HasSubstr("at least one value"));
  EXPECT_THAT(refusal("/version", 2), HasSubstr("/version"));
  EXPECT_THAT(test::message_of([] { find_suite("quik"); }), AllOf(HasSubstr("quick"), HasSubstr(".json")));
}

TEST(Suite, ShippedOnesAreReadAndTakeEveryTechnique) {
  for (const std::string& name : shipped_suite_names()) {
    SCOPED_TRACE(name);
    const Suite suite = find_suite(name);
    EXPECT_EQ(suite.name, name);
    EXPECT_TRUE(suite.techniques.empty()) << "all";
    EXPECT_EQ(suite.edits.size(), 4u);
    const std::vector<SceneCase> cases = scene_cases(suite, {});
    std::set<std::string> seen;
    for (const Cell& cell : enumerate_cells(suite, cases, {})) seen.insert(cell.name + " " + cell.backend);
    for (const Technique& technique : techniques())
      for (const char* backend : {" cpu", " gpu"}) EXPECT_EQ(seen.count(technique.name + backend), 1u);
  }
}

TEST(Cells, AreTheProductOfScenesMaterialsTechniquesAndSettings) {
  const Suite suite = parse_suite(test::tiny_suite(), "tiny.json");
  const std::vector<SceneCase> cases = scene_cases(suite, {});
  ASSERT_EQ(cases.size(), 3u);
  EXPECT_EQ(cases[1].material, "wholemilk");
  EXPECT_EQ(cases[2].material, "m1");
  const std::vector<Cell> cells = enumerate_cells(suite, cases, {});
  EXPECT_EQ(cells.size(), 3u * (1 + 2));
  std::set<std::string> hashes;
  for (const Cell& cell : cells) hashes.insert(cell.hash);
  EXPECT_EQ(hashes.size(), cells.size());
  CellChoice choice{.scenes = {"side"}, .techniques = {"hierarchical"}, .backends = {}, .externals = {}, .gl = ""};
  EXPECT_EQ(enumerate_cells(suite, scene_cases(suite, choice), choice).size(), 2u);
  choice.techniques = {"path_traced"};
  EXPECT_THAT(test::message_of([&] { enumerate_cells(suite, cases, choice); }), HasSubstr("--technique"));
  choice.scenes = {"sid"};
  EXPECT_THAT(test::message_of([&] { scene_cases(suite, choice); }), HasSubstr("did you mean \"side\""));
}

TEST(Cells, HashesFollowTheContent) {
  test::TempFolder folder;
  folder.write("mesh.obj", test::tetrahedron_obj);
  json document = test::tiny_suite();
  document["scenes"][1]["scene"]["objects"] = {{{"mesh", "mesh.obj"}, {"material", "m1"}}};
  const auto hashes = [&](const json& suite) {
    const Suite s = parse_suite(suite, folder.file("s.json"));
    std::vector<std::string> all;
    for (const Cell& cell : enumerate_cells(s, scene_cases(s, {}), {})) all.push_back(cell.hash);
    return all;
  };
  const std::vector<std::string> before = hashes(document);
  EXPECT_EQ(hashes(document), before);
  folder.write("mesh.obj", std::string(test::tetrahedron_obj) + "\n");
  const std::vector<std::string> after = hashes(document);
  EXPECT_EQ(after[0], before[0]) << "another scene's mesh";
  EXPECT_NE(after[8], before[8]) << "the file that the scene names";
  document["samples"] = 201;
  EXPECT_NE(hashes(document)[0], before[0]);
}

TEST(Cells, HashesFollowThreadsAndWhereItIsUsedTheGl) {
  json document = test::tiny_suite();
  document["backends"] = {"cpu", "gpu"};
  const Suite suite = parse_suite(document, "tiny.json");
  const auto cells = [&](const CellChoice& choice) { return enumerate_cells(suite, scene_cases(suite, {}), choice); };
  CellChoice gl, threads;
  gl.gl = "osmesa", threads.threads = 1;
  const std::vector<Cell> plain = cells({}), by_gl = cells(gl), by_threads = cells(threads);
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_NE(by_threads[i].hash, plain[i].hash) << "times are others";
    EXPECT_EQ(by_gl[i].hash != plain[i].hash, plain[i].backend == "gpu");
  }
}

TEST(External, NeedsANameACommandAndItsPlaces) {
  EXPECT_EQ(parse_external("mine=render {scene} -o {out}").name, "mine");
  for (const char* text : {"render {scene} {out}", "=x {scene} {out}", "mine=x {scene}", "mine=x {out}"})
    EXPECT_THAT(test::message_of([&] { parse_external(text); }), HasSubstr("--external")) << text;
}

}  // namespace
}  // namespace opaline
