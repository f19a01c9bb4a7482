// Running a suite: what a record holds, what is not measured twice, and what happens to cells that can't be done.
#include "validate/matrix.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/validate/validate_fixture.h"
#include "validate/metrics/metric.h"
#include "validate/shared_file.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

TEST(Matrix, ARecordHoldsTimesErrorsImagesAndWhereItCameFrom) {
  test::TempFolder folder;
  json suite = test::tiny_suite();
  suite["edits"] = {"camera", "light", "material", "geometry"};
  suite["truth"] = {{"paths", 2}, {"scenes", {"front"}}};
  suite["max_seconds"] = 100;  // a busy machine must not leave out a run
  const RunSummary summary = test::run_tiny(folder, suite);
  ASSERT_EQ(summary.records.size(), 9u);
  EXPECT_EQ(summary.measured, 9u);
  for (const Record& r : summary.records) {
    SCOPED_TRACE(r.name());
    ASSERT_EQ(r.status, CellStatus::done) << r.reason;
    EXPECT_GT(r.seconds.render.median, 0);
    EXPECT_GE(r.seconds.render.runs, 2);
    EXPECT_LE(r.seconds.render.min, r.seconds.render.median);
    EXPECT_EQ(r.error.size(), metrics().size());
    EXPECT_LT(r.error.at("relative_rmse"), r.settings.count("max_relative_error") ? 0.1 : 1e-3);
    EXPECT_EQ(r.truth_error.has_value(), r.scene == "front");
    EXPECT_GT(r.reference.certified_max, 0);
    EXPECT_EQ(r.film_pixels, 100u);
    EXPECT_GT(r.peak_rss_bytes, 1000000u);
    EXPECT_GT(r.done.at("surface_cells"), 0u);
    for (const char* edit : {"camera", "light", "material", "geometry"}) {
      const EditCost& cost = r.seconds.edits.at(edit);
      EXPECT_GT(cost.render, 0) << edit;
      EXPECT_NEAR(cost.total, cost.shared + cost.prepare + cost.render, 1e-12);
    }
    EXPECT_EQ(r.seconds.edits.at("camera").prepare, 0) << "what was prepared survives";
    EXPECT_GT(r.seconds.edits.at("light").prepare, 0);
    for (const auto& [what, file] : r.images)
      EXPECT_TRUE(fs::exists(folder.file("out/" + file))) << what << " " << file;
    EXPECT_THAT(r.command, HasSubstr("opaline render scenes/" + r.scene + "_" + r.material + ".json"));
    EXPECT_TRUE(fs::exists(folder.file("out/scenes/" + r.scene + "_" + r.material + ".json")));
  }
  EXPECT_EQ(read_records(folder.file("out/records.jsonl")).records.size(), 9u);
}

TEST(Matrix, AnEditLeavesNoTrace) {
  test::TempFolder plain, edited;
  json suite = test::tiny_suite();
  const RunSummary before = test::run_tiny(plain, suite);
  suite["edits"] = {"geometry", "camera", "light", "material"};
  const RunSummary after = test::run_tiny(edited, suite);
  for (std::size_t i = 0; i < before.records.size(); ++i) {
    EXPECT_EQ(before.records[i].error, after.records[i].error) << before.records[i].name();
    EXPECT_EQ(before.records[i].done, after.records[i].done);
  }
}

TEST(Matrix, MeasuresNothingAgainUnlessAsked) {
  test::TempFolder folder;
  const RunSummary first = test::run_tiny(folder);
  const RunSummary second = test::run_tiny(folder);
  EXPECT_EQ(second.measured, 0u);
  ASSERT_EQ(second.records.size(), first.records.size());
  for (std::size_t i = 0; i < first.records.size(); ++i)
    EXPECT_EQ(to_json(second.records[i]), to_json(first.records[i]));
  json wider = test::tiny_suite();
  wider["sweeps"]["hierarchical"][0]["max_relative_error"].push_back("1e-2");
  EXPECT_EQ(test::run_tiny(folder, wider).measured, 3u);
  EXPECT_EQ(test::run_tiny(folder, test::tiny_suite(), true).measured, 9u);
  EXPECT_EQ(read_records(folder.file("out/records.jsonl")).records.size(), 12u);
}

TEST(Matrix, SharedPartsComeFromTheirFileAndADamagedOneIsMadeAgain) {
  test::TempFolder folder;
  const RunSummary first = test::run_tiny(folder);
  std::vector<std::string> parts;
  for (const auto& entry : fs::directory_iterator(folder.file("out/cache")))
    if (entry.path().extension() == ".bin") parts.push_back(entry.path().string());
  ASSERT_EQ(parts.size(), 3u);
  const std::optional<SceneParts> kept = load_scene_parts(parts[0]);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->meshes.size(), 1u);
  EXPECT_GT(kept->shared.view.points.size(), 10u);
  for (const std::string& file : parts) fs::resize_file(file, fs::file_size(file) - 5);
  EXPECT_FALSE(load_scene_parts(parts[0]));
  // From the files, and made anew: the same pixels, so the same errors.
  for (int round = 0; round < 2; ++round) {
    const RunSummary again = test::run_tiny(folder, test::tiny_suite(), true);
    for (std::size_t i = 0; i < first.records.size(); ++i) EXPECT_EQ(again.records[i].error, first.records[i].error);
  }
  EXPECT_TRUE(load_scene_parts(parts[0]));
}

TEST(Matrix, WhatCannotBeDoneHasItsReason) {
  test::TempFolder folder;
  json suite = test::tiny_suite();
  suite["backends"] = {"cpu", "gpu"};
  suite["techniques"] = {"path_traced", "hierarchical"};
  suite["sweeps"] = {{"path_traced", {{{"paths", 2}}}}};
  json open = suite["scenes"][1]["scene"], broken = open;
  folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  open["objects"] = {{{"mesh", folder.file("open.obj")}, {"material", "m1"}, {"transform", {{"scale", 5}}}}};
  broken["objects"] = {{{"mesh", folder.file("none.obj")}, {"material", "m1"}}};
  suite["scenes"] = {{{"name", "open"}, {"scene", open}}, {{"name", "broken"}, {"scene", broken}}};
  RunOptions options;
  options.folder = folder.file("out");
  options.choice.gl = "egl";
  const RunSummary summary = run_suite(parse_suite(suite, "s.json"), options, test::test_shapes());
  ASSERT_EQ(summary.records.size(), 8u);
  for (const Record& r : summary.records) {
    SCOPED_TRACE(r.name());
    if (r.scene == "broken") {
      EXPECT_EQ(r.status, CellStatus::failed);
      EXPECT_THAT(r.reason, HasSubstr("none.obj"));
    } else if (r.technique == "path_traced") {
      EXPECT_EQ(r.status, CellStatus::not_applicable);
      EXPECT_THAT(r.reason, HasSubstr(r.backend == "cpu" ? "not closed" : "no gpu backend"));
      EXPECT_EQ(r.seconds.render.runs, 0);
    } else {
      // On the GPU only where there is one.
      EXPECT_TRUE(r.status == CellStatus::done || r.backend == "gpu") << r.reason;
      EXPECT_NE(r.status, CellStatus::failed) << r.reason;
    }
  }
  // What failed is tried again, what is done or not applicable isn't.
  EXPECT_EQ(run_suite(parse_suite(suite, "s.json"), options, test::test_shapes()).measured, 4u);
}

// The cell renders and is compared with the truth before it fails: the reference cannot be written.
TEST(Matrix, WhatFailsLateHoldsNoFigure) {
  test::TempFolder folder;
  json suite = test::tiny_suite();
  suite["scenes"].erase(0);
  suite["techniques"] = {"brute_force"};
  suite["truth"] = {{"paths", 2}};
  Record done = test::run_tiny(folder, suite).records.at(0);
  ASSERT_EQ(done.status, CellStatus::done) << done.reason;
  ASSERT_TRUE(done.truth_error);
  ASSERT_FALSE(done.done.empty());
  const std::string facts = fs::path(done.images.at("reference")).stem().string();
  fs::remove_all(folder.file("out/cache/" + facts + ".json"));
  fs::remove(folder.file("out/" + done.images.at("reference")));
  fs::create_directories(folder.file("out/" + done.images.at("reference")));
  const Record failed = test::run_tiny(folder, suite, true).records.at(0);
  ASSERT_EQ(failed.status, CellStatus::failed);
  EXPECT_FALSE(failed.reason.empty());
  Record blank = failed;
  blank.seconds = {}, blank.peak_rss_bytes = 0, blank.error.clear(), blank.truth_error.reset();
  blank.reference = {}, blank.done.clear(), blank.skipped.clear(), blank.images.clear();
  blank.seconds.harness_overhead = failed.seconds.harness_overhead;
  EXPECT_EQ(to_json(failed), to_json(blank));
}

// Materials are called "Head & Shoulders Shampoo" or what a user likes; a command is pasted into a shell.
TEST(Matrix, FilesOfScenesAreOneWordWhateverMaterialsAreCalled) {
  test::TempFolder folder;
  json suite = test::tiny_suite();
  suite["scenes"][0]["materials"] = {"Head & Shoulders Shampoo"};
  suite["scenes"][1]["scene"]["materials"] = {{"a/b c", suite["scenes"][1]["scene"]["materials"]["m1"]}};
  suite["scenes"][1]["scene"]["objects"][0]["material"] = "a/b c";
  suite["techniques"] = {"brute_force"};
  const RunSummary summary = test::run_tiny(folder, suite);
  ASSERT_EQ(summary.records.size(), 2u);
  for (const Record& r : summary.records) {
    ASSERT_EQ(r.status, CellStatus::done) << r.reason;
    const std::string file = r.scene == "front" ? "front_Head___Shoulders_Shampoo" : "side_a_b_c";
    EXPECT_THAT(r.command, HasSubstr("opaline render scenes/" + file + ".json --technique"));
    EXPECT_TRUE(fs::exists(folder.file("out/scenes/" + file + ".json")));
  }
}

TEST(Matrix, AnExternalRendererIsJudgedByTheSameReference) {
  test::TempFolder folder;
  const RunSummary ours = test::run_tiny(folder);
  RunOptions options;
  options.folder = folder.file("out");
  const std::string render = "cp " + folder.file("out/" + ours.records[0].images.at("render")) + " {out}";
  options.choice.externals = {{"copy", "test -s {scene} && " + render},
                              {"fails", "echo no licence >&2; exit 7 # {scene} {out}"},
                              {"lazy", "true {scene} {out}"}};
  options.choice.scenes = {"front"};
  options.choice.techniques = {"copy", "fails", "lazy"};
  const Suite suite = parse_suite(test::tiny_suite(), "tiny.json");
  const RunSummary summary = run_suite(suite, options, test::test_shapes());
  ASSERT_EQ(summary.records.size(), 6u);
  EXPECT_EQ(summary.records[0].status, CellStatus::done) << summary.records[0].reason;
  EXPECT_EQ(summary.records[0].backend, "external");
  EXPECT_EQ(summary.records[0].error, ours.records[0].error);
  EXPECT_GT(summary.records[0].seconds.render.median, 0);
  EXPECT_EQ(summary.records[1].status, CellStatus::failed);
  EXPECT_THAT(summary.records[1].reason, testing::AllOf(HasSubstr("exit code 7"), HasSubstr("no licence")));
  EXPECT_THAT(summary.records[2].reason, HasSubstr("wrote no"));
}

TEST(Matrix, LayeredDatasetsAreWrittenAndJudgedByExactSingleScattering) {
  test::TempFolder folder;
  json suite = test::tiny_suite();
  suite["scenes"] = {{{"name", "fish"}, {"recipe", "fish_layers"}, {"film", {{"width", 8}, {"height", 4}}}}};
  suite["techniques"] = {"subsurface_texture", "brute_force"};
  suite["layered_reference"] = {{"max_relative_error", "0.1"}};
  suite["edits"] = {"material", "geometry"};
  suite.erase("sweeps");
  RunOptions options;
  options.folder = folder.file("out");
  const RunSummary summary = run_suite(parse_suite(suite, "tiny.json"), options, synthetic_shapes());
  EXPECT_TRUE(fs::exists(folder.file("out") + "/scenes/fish_layers/depths.exr"));
  ASSERT_EQ(summary.records.size(), 2u);
  for (const Record& r : summary.records) {
    if (r.technique == "brute_force") {
      EXPECT_EQ(r.status, CellStatus::not_applicable);
      continue;
    }
    ASSERT_EQ(r.status, CellStatus::done) << r.reason;
    EXPECT_LT(r.error.at("relative_rmse"), 0.2);
    EXPECT_GT(r.error.at("relative_rmse"), 1e-4) << "not itself";
    EXPECT_GT(r.reference.certified_max, 0);
    EXPECT_EQ(r.seconds.edits.size(), 2u);
  }
  // The dataset's files are the same ones in the next run, so that its cells are.
  const std::string depths = folder.file("out") + "/scenes/fish_layers/depths.exr";
  const fs::file_time_type written = fs::last_write_time(depths);
  EXPECT_EQ(run_suite(parse_suite(suite, "tiny.json"), options, synthetic_shapes()).measured, 0u);
  EXPECT_EQ(fs::last_write_time(depths), written);
  fs::resize_file(depths, fs::file_size(depths) / 2);
  options.choice.techniques = {"brute_force"};
  run_suite(parse_suite(suite, "tiny.json"), options, synthetic_shapes());
  EXPECT_GT(read_image(depths).width, 1) << "what is damaged is written again";
}

}  // namespace
}  // namespace opaline
