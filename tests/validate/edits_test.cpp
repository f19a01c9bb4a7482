// Edits over the registry: what a technique says survives an edit must do so.
#include "validate/edits.h"

#include "tests/validate/validate_fixture.h"
#include "validate/measured_scene.h"

#include <gtest/gtest.h>

namespace opaline {
namespace {

using nlohmann::json;

class Edits : public ::testing::TestWithParam<std::string> {};

TEST_P(Edits, WhatIsNotPreparedAgainIsStillRight) {
  test::TempFolder folder;
  const Suite suite = parse_suite(test::tiny_suite(), "tiny.json");
  const std::vector<SceneCase> cases = scene_cases(suite, {});
  MeasuredScene scene(suite, cases.front(), test::test_shapes(), folder.file("out"));
  const Technique& technique = find_technique(GetParam());
  if (const std::string reason = why_not_applicable(technique, scene.scene); !reason.empty()) GTEST_SKIP() << reason;
  SettingValues settings;
  if (technique.name == "path_traced") settings["paths"] = "2";
  TechniqueRun run(scene, technique, settings, nullptr);
  run.prepare();
  run.render();
  const std::vector<float> unedited = run.image.data;
  for (const char* edit : {"camera", "light", "material", "geometry"}) {
    SCOPED_TRACE(edit);
    run.prepare();
    measure_edit_once(edit, run);
    EXPECT_FALSE(run.is_prepared()) << "the shared parts have been put back, elsewhere";
    const std::vector<float> as_said = run.image.data;
    run.prepare();
    measure_edit_once(edit, run, true);
    EXPECT_EQ(as_said, run.image.data);
    EXPECT_NE(as_said, unedited) << "the edit changes the picture";
    run.prepare();
    run.render();
    EXPECT_EQ(run.image.data, unedited) << "the edit was taken back";
  }
}

// What a setting ties to its view is prepared again for another one, not refused.
// Its vertices are closer than the picture moves, so that it sees others.
TEST(EditsOfSettings, AFixedViewIsPreparedAgainAfterAnEditOfTheCamera) {
  test::TempFolder folder;
  json suite = test::tiny_suite();
  suite["scenes"].erase(0);
  suite["techniques"] = {"precomputed_transfer"};
  suite["sweeps"] = {{"precomputed_transfer", {{{"view", {"fixed", "any"}}, {"directions", 20}, {"subdivide", 16}}}}};
  suite["edits"] = {"light", "camera"};
  const RunSummary summary = test::run_tiny(folder, suite);
  ASSERT_EQ(summary.records.size(), 2u);
  for (const Record& r : summary.records) {
    SCOPED_TRACE(r.name());
    ASSERT_EQ(r.status, CellStatus::done) << r.reason;
    EXPECT_EQ(r.seconds.edits.at("camera").prepare > 0, r.settings.at("view") == "fixed");
  }
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const Technique& technique : techniques()) all.push_back(technique.name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(Registry, Edits, ::testing::ValuesIn(names()), [](const auto& row) { return row.param; });

}  // namespace
}  // namespace opaline
