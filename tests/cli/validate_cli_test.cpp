// `opaline validate` as a user runs it: killed and gone on with, gates, JUnit, a choice out of records.
#include "render/image.h"
#include "tests/validate/validate_fixture.h"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cstdlib>
#include <sstream>

namespace opaline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ValidateCli : public ::testing::Test {
 protected:
  ValidateCli() { folder_.write("suite.json", suite().dump()); }

  static json suite() {
    json document = test::tiny_suite();
    for (json& scene : document["scenes"])
      scene["scene"]["objects"] = {{{"shape", "sphere"}, {"radius", 5}, {"triangles", 200}, {"material", "m1"}}};
    return document;
  }

  /// Runs a script in the folder, where $opaline is the program. Returns the exit status; output is in "out" and "err".
  int sh(const std::string& script) {
    folder_.write("script", script);
    const std::string command = "cd '" + folder_.file("") + "' && opaline='" OPALINE_BINARY "' sh script >out 2>err";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string content(const std::string& name) const {
    std::ifstream in(folder_.file(name));
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
  std::size_t lines(const std::string& name) const {
    const std::string text = content(name);
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }

  test::TempFolder folder_;
};

TEST_F(ValidateCli, KilledAtAnyMomentItGoesOnWithWhatIsMissing) {
  json slow = suite();
  slow["runs"] = 20;
  slow["max_seconds"] = 1;
  folder_.write("slow.json", slow.dump());
  sh("$opaline validate slow.json --out r & pid=$!\n"
     "until [ $(cat r/records.jsonl 2>/dev/null | wc -l) -ge 2 ]; do sleep 0.01; done\n"
     "kill -9 $pid; wait; exit 0");
  const std::size_t before = lines("r/records.jsonl");
  ASSERT_GE(before, 2u);
  ASSERT_LT(before, 9u) << "it was too quick to be killed";
  const std::string first = content("r/records.jsonl").substr(0, content("r/records.jsonl").find('\n'));
  // As if the kill had come in the middle of a line.
  std::ofstream(folder_.file("r/records.jsonl"), std::ios::app) << first.substr(0, 200);
  ASSERT_EQ(sh("$opaline validate slow.json --out r"), 0) << content("err");
  const RecordFile file = read_records(folder_.file("r/records.jsonl"));
  EXPECT_EQ(file.records.size(), 9u);
  EXPECT_EQ(file.superseded, 0u) << "nothing was measured twice";
  EXPECT_EQ(content("r/records.jsonl").rfind(first, 0), 0u) << "what was there stays";
  ASSERT_EQ(sh("$opaline validate slow.json --out r --quiet"), 0);
  EXPECT_THAT(content("out"), HasSubstr("9 cells done, 0 not applicable, 0 failed; 0 measured now"));
}

TEST_F(ValidateCli, ACrashIsTheEndOfItsCellAlone) {
  json slow = suite();
  slow["runs"] = 20;
  slow["max_seconds"] = 1;
  folder_.write("slow.json", slow.dump());
  const int status =
      sh("$opaline validate slow.json --out r & pid=$!\n"
         "until [ $(cat r/records.jsonl 2>/dev/null | wc -l) -ge 1 ] && [ -s r/measuring ]; do sleep 0.01; done\n"
         "child=$(cat /proc/$pid/task/$pid/children); kill -SEGV $child; wait $pid");
  EXPECT_EQ(status, 0) << content("err");
  EXPECT_THAT(content("err"), HasSubstr("going on"));
  std::size_t failed = 0;
  for (const Record& r : read_records(folder_.file("r/records.jsonl")).records) {
    if (r.status != CellStatus::failed) continue;
    ++failed;
    EXPECT_THAT(r.reason, HasSubstr("signal 11"));
  }
  EXPECT_EQ(failed, 1u);
  EXPECT_THAT(content("out"), HasSubstr("8 cells done, 0 not applicable, 1 failed"));
}

TEST_F(ValidateCli, GatesFailTheRunAndSayWhere) {
  const json gate = {{"name", "clusters are exact"},
                     {"figure", {{"error", "relative_rmse"}, {"technique", "hierarchical"}}},
                     {"max", 1e-9}};
  json gates = {{"format", "opaline-gates"}, {"version", 1}, {"gates", {gate}}};
  folder_.write("gates.json", gates.dump());
  EXPECT_EQ(sh("$opaline validate suite.json --out r --gates gates.json --junit r.xml"), 1);
  EXPECT_THAT(content("out"), AllOf(HasSubstr("FAILED"), HasSubstr("clusters are exact"), HasSubstr("1e-1")));
  EXPECT_THAT(content("err"), HasSubstr("1 gates fell short"));
  EXPECT_THAT(content("r.xml"), HasSubstr("failures=\"1\""));
  EXPECT_EQ(json::parse(content("r/gates.json")).at("gates")[0].at("outcome"), "failed");
  gates["gates"][0]["max"] = 1;
  folder_.write("gates.json", gates.dump());
  EXPECT_EQ(sh("$opaline validate suite.json --out r --gates gates.json --junit r.xml --quiet"), 0) << content("out");
  EXPECT_THAT(content("r.xml"), HasSubstr("failures=\"0\""));
  EXPECT_EQ(sh("$opaline validate suite.json --out r --quiet --baseline r"), 0) << content("out");
  EXPECT_THAT(content("out"), HasSubstr("nothing changed"));
}

TEST_F(ValidateCli, WrongInputIsRefusedBeforeAnyWork) {
  folder_.write("bad.json", "{\"format\": \"opaline-gates\", \"version\": 1, \"gates\": []}");
  const std::pair<const char*, const char*> rows[] = {
      {"validate quik --out r", "did you mean \"quick\""},
      {"validate none.json --out r", "does not exist"},
      {"validate suite.json", "--out is required"},
      {"validate suite.json --out r --gates bad.json", "at least one gate"},
      {"validate suite.json --out r --junit no/r.xml", "does not exist"},
      {"validate suite.json --out r --baseline none", "none"},
      {"validate suite.json --out r --scene frnt", "did you mean \"front\""},
      {"validate suite.json --out r --technique brute", "--technique"},
      {"validate suite.json --out r --external mine", "NAME=COMMAND"},
      {"render scene.json --max-error 0.1 --out a.exr", "--records"},
      {"render scene.json --max-error 0.1 --budget 3 --records r --out a.exr", "one of the two"},
      {"render scene.json --max-error 0.1 --technique brute_force --records r --out a.exr", "leave out"}};
  for (const auto& [arguments, part] : rows) {
    EXPECT_EQ(sh(std::string("$opaline ") + arguments), 2) << arguments << content("err");
    EXPECT_THAT(content("err"), HasSubstr(part)) << arguments;
    EXPECT_FALSE(fs::exists(folder_.file("r/records.jsonl")));
  }
}

TEST_F(ValidateCli, RenderChoosesFromRecordsAndSaysWhy) {
  ASSERT_EQ(sh("$opaline validate suite.json --out r"), 0) << content("err");
  const Record record = read_records(folder_.file("r/records.jsonl")).records.back();
  const std::string command = "$" + record.command;  // "$opaline render ..."
  ASSERT_EQ(sh("cd r && " + command + " && $opaline compare image.exr " + record.images.at("render") + " --max-rmse 0"),
            0)
      << "the recorded command makes the recorded image: " << content("err");
  const std::string render = "$opaline render r/scenes/side_m1.json --records r --stats s.json --out ";
  ASSERT_EQ(sh(render + "a.exr --max-error 1e-5"), 0) << content("err");
  EXPECT_THAT(content("err"), AllOf(HasSubstr("brute_force on the cpu"), HasSubstr("relative_rmse at most")));
  EXPECT_EQ(json::parse(content("s.json")).at("technique"), "brute_force");
  EXPECT_EQ(json::parse(content("s.json")).at("settings").at("samples"), 100);
  ASSERT_EQ(sh(render + "b.exr --budget 1e9"), 0) << content("err");
  EXPECT_EQ(json::parse(content("s.json")).at("technique"), "brute_force") << "the most accurate";
  ASSERT_EQ(sh(render + "c.exr --max-error 0.5"), 0) << content("err");
  EXPECT_THAT(content("err"), HasSubstr("the fastest of 3 ways"));
  EXPECT_EQ(sh(render + "d.exr --max-error 1e-30"), 2);
  EXPECT_THAT(content("err"), AllOf(HasSubstr("nothing measured keeps the limit"), HasSubstr("brute_force")));
}

}  // namespace
}  // namespace opaline
