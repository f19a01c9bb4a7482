// Records come back as they were written, and a file survives being cut.
#include "validate/record.h"
#include "tests/render/scene_fixture.h"

#include <gmock/gmock.h>

#include <limits>

namespace opaline {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Record example() {
  Record r;
  r.cell = "0123456789abcdef";
  r.suite = "quick";
  r.scene = "sphere", r.material = "skin1", r.technique = "hierarchical", r.backend = "gpu";
  r.settings = {{"max_relative_error", "1e-3"}};
  r.seconds.prepare = make_timing({0.25, 0.5, 0.125});
  r.seconds.render = make_timing({2, 1});
  r.seconds.load = 0.5, r.seconds.gbuffer = 0.0625, r.seconds.irradiance = 3;
  r.seconds.edits["light"] = {4, 3, 0.5, 0.5};
  r.seconds.harness_overhead = 0.001;
  r.peak_rss_bytes = 123456789;
  r.error = {{"rmse", 0.25}, {"psnr", std::numeric_limits<double>::infinity()}};
  r.truth_error = {{"rmse", 0.5}};
  r.reference = {{{"max_relative_error", "1e-4"}}, 1e-4, 2e-4, 5, 0.01, 60};
  r.done = {{"rays", 7}}, r.skipped = {{"cells", 9}};
  r.images = {{"render", "images/a.exr"}};
  r.machine = {"a processor", 2, "llvmpipe, software renderer", "0.1.0", "g++", "fedc", "2026-01-02T03:04:05Z"};
  r.seed = 5;
  r.command = "opaline render scene.json";
  return r;
}

TEST(Record, ComesBackAsItWasWritten) {
  const nlohmann::ordered_json written = to_json(example());
  const Record again = record_from_json(nlohmann::json::parse(written.dump()), "f", "line 1");
  EXPECT_EQ(to_json(again), written);
  EXPECT_EQ(again.seconds.edits.at("light").shared, 3);
  EXPECT_EQ(again.error.at("psnr"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(again.truth_error->at("rmse"), 0.5);
  Record failed;
  failed.status = CellStatus::failed, failed.reason = "no memory";
  const nlohmann::ordered_json json = to_json(failed);
  EXPECT_FALSE(json.contains("truth_error"));
  EXPECT_EQ(record_from_json(nlohmann::json::parse(json.dump()), "f", "").reason, "no memory");
}

TEST(Record, TimingsAreOrderedByNothingButTheirTime) {
  const Timing odd = make_timing({3, 1, 2}), even = make_timing({4, 1, 3, 2});
  EXPECT_EQ(odd.median, 2);
  EXPECT_EQ(odd.min, 1);
  EXPECT_EQ(odd.values, (std::vector<double>{3, 1, 2}));
  EXPECT_EQ(even.median, 2.5);
  EXPECT_EQ(even.runs, 4);
}

TEST(RecordFile, ACutLastLineIsSaidAndLosesNothingElse) {
  test::TempFolder folder;
  const std::string path = folder.file("records.jsonl");
  Record a = example(), b = example();
  b.scene = "torus";
  {
    RecordWriter writer(path);
    writer.append(a);
    writer.append(b);
  }
  const std::string whole = read_records(path).records[1].scene;
  EXPECT_EQ(whole, "torus");
  const auto size = std::filesystem::file_size(path);
  for (const std::uintmax_t cut : {size - 1, size - 2, size - 100}) {
    std::filesystem::resize_file(path, cut);
    const RecordFile file = read_records(path);
    // Without its line end alone the last record is still whole.
    EXPECT_EQ(file.records.size(), cut == size - 1 ? 2u : 1u);
    EXPECT_EQ(file.cut, cut != size - 1);
    if (cut == size - 1) {
      RecordWriter keeps(path);  // what is read is kept
      EXPECT_EQ(read_records(path).records.size(), 2u);
    }
  }
  RecordWriter(path).append(b);
  const RecordFile file = read_records(path);
  EXPECT_FALSE(file.cut);
  ASSERT_EQ(file.records.size(), 2u);
  EXPECT_EQ(file.records[0].scene, "sphere");
}

TEST(RecordFile, TheLastOfTwoMeasurementsOfACellCounts) {
  test::TempFolder folder;
  const std::string path = folder.file("records.jsonl");
  Record a = example(), b = example(), other = example();
  other.settings["max_relative_error"] = "1e-2";
  b.cell = "another program", b.seconds.load = 9;
  RecordWriter writer(path);
  for (const Record& r : {a, other, b}) writer.append(r);
  const RecordFile file = read_records(path);
  EXPECT_EQ(file.superseded, 1u);
  ASSERT_EQ(file.records.size(), 2u);
  EXPECT_EQ(file.records[1].seconds.load, 9);
}

TEST(RecordFile, BadLinesAreNamed) {
  test::TempFolder folder;
  const std::string good = to_json(example()).dump() + "\n";
  const auto message = [&](const std::string& text) {
    return test::message_of([&] { read_records(folder.write("r.jsonl", text)); });
  };
  EXPECT_THAT(message(good + "{\n" + good), AllOf(HasSubstr("r.jsonl: line 2"), HasSubstr("JSON")));
  // Ended, so not cut: a writer would leave it where it is, and what comes after it would never be read.
  EXPECT_THAT(message(good + "{\n"), AllOf(HasSubstr("r.jsonl: line 2"), HasSubstr("JSON")));
  EXPECT_THAT(message(good + "{\"a\": 1}\n"), AllOf(HasSubstr("line 2"), HasSubstr("opaline-record")));
  EXPECT_THAT(message("[1]\n"), AllOf(HasSubstr("line 1"), HasSubstr("object")));
  std::string wrong = good;
  wrong.replace(wrong.find("\"done\""), 6, "\"donn\"");
  EXPECT_THAT(message(wrong), AllOf(HasSubstr("donn"), HasSubstr("not_applicable")));
  wrong = good;
  wrong.replace(wrong.find("\"psnr\":null"), 11, "\"psnr\":\"x\"");
  EXPECT_THAT(message(wrong), AllOf(HasSubstr("/error/psnr"), HasSubstr("number or null")));
  EXPECT_THAT(test::message_of([&] { read_records(folder.file("none.jsonl")); }), HasSubstr("does not exist"));
}

}  // namespace
}  // namespace opaline
