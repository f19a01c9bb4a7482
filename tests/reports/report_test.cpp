// The whole report, its sections, and the command: sizes, completeness, bad input.
#include "reports/report.h"
#include "reports/csv.h"
#include "reports/sections/section.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/report_fixture.h"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cstdlib>

namespace opaline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Report : public ::testing::Test {
 protected:
  /// The folder "d" with made-up results, read.
  ReportData read(const test::ReportFolder& options = {}) {
    test::write_report_folder(folder_.file("d"), options);
    return read_report_data(folder_.file("d"));
  }
  std::string page(const ReportData& data) { return report_html(write_sections(data), report_title(data)); }
  std::string text(const ReportData& data) { return report_markdown(write_sections(data), report_title(data)); }

  /// Exit code of the binary; its stderr is in err_.
  int run(const std::string& arguments) {
    const std::string err = folder_.file("err.txt");
    const int status = std::system(
        ("cd '" + folder_.file("") + "' && '" OPALINE_BINARY "' report " + arguments + " >/dev/null 2>'" + err + "'")
            .c_str());
    std::ifstream in(err);
    err_.assign(std::istreambuf_iterator<char>(in), {});
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  void expect_wrong(const std::string& arguments, const std::string& message) {
    EXPECT_EQ(run(arguments), 2) << err_;
    EXPECT_THAT(err_, HasSubstr(message));
    EXPECT_EQ(std::count(err_.begin(), err_.end(), '\n'), 1) << "one message: " << err_;
    EXPECT_FALSE(std::filesystem::exists(folder_.file("r.html")));
  }

  test::TempFolder folder_;
  std::string err_;
};

TEST_F(Report, StandsAlone) {
  const std::string html = page(read({.pictured = 9}));
  EXPECT_TRUE(has_plotting_library()) << "./run build installs it";
  for (const char* reference : {"<link", " src=\"http", " src=\"/", "<script src", "@import", "url(http"})
    EXPECT_THAT(html, Not(HasSubstr(reference)));
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));
}

TEST_F(Report, EscapesEveryTextOfTheRecords) {
  const std::string html = page(read());
  for (const char* raw : {"<b>\"front\"", "out of <memory>", "GPU <over> CPU", "broken <profile>"})
    EXPECT_THAT(html, Not(HasSubstr(raw)));
  EXPECT_THAT(html, HasSubstr("bust &lt;b&gt;&quot;front&quot;&lt;/b&gt; &amp; &#39;side&#39; | x"));
}

TEST_F(Report, HasNoEmptyCell) {
  for (const Chapter& chapter : write_sections(read()))
    for (const Block& block : chapter.blocks)
      if (const Table* table = std::get_if<Table>(&block))
        for (const auto& row : table->rows) {
          ASSERT_EQ(row.size(), table->header.size()) << table->caption;
          for (const TableCell& cell : row)
            EXPECT_FALSE(cell.text.empty()) << table->caption << ": " << row.front().text;
        }
}

TEST_F(Report, SaysWhatFailedAndWhatIsNotApplicable) {
  const std::string markdown = text(read());
  EXPECT_THAT(markdown, HasSubstr("out of \\<memory\\>"));
  EXPECT_THAT(markdown, HasSubstr("the command has no GPU backend"));
  EXPECT_THAT(markdown, HasSubstr("1 of 3 gates fell short"));
  EXPECT_THAT(markdown, HasSubstr("the technique has no gpu backend")) << "path\\_traced, not in the records";
}

TEST_F(Report, ExternalTechniquesHaveAColumnOfTheirOwn) {
  ReportData data = read({.records = 24, .extras = false});
  for (Record& r : data.records)
    if (r.technique == "external_renderer" && r.backend == "cpu") r.backend = "external";
  const std::string markdown = text(data);
  EXPECT_THAT(markdown, HasSubstr("| scene, material | technique | cpu | gpu | external |"));
  EXPECT_THAT(markdown, HasSubstr("an external command: it has no backends"));
  EXPECT_THAT(markdown, HasSubstr("| built in |"));
}

TEST_F(Report, ComparesProcessorsAndCountsSkips) {
  const std::string markdown = text(read());
  EXPECT_THAT(markdown, HasSubstr("| hierarchical | 9 | 0.625 | 0.625 to 0.625 | software renderer |"))
      << "1 / 1.6, three scenes' samples";
  EXPECT_THAT(markdown, HasSubstr("| 75 % | 75 % in ")) << "3000 of 4000 samples are skipped everywhere";
  ReportData all_skipped = read();
  for (Record& r : all_skipped.records) r.done["samples"] = 0, r.skipped["rays"] = 0, r.done.erase("rays");
  const std::string without = text(all_skipped);
  EXPECT_THAT(without, HasSubstr("| samples | 0 | "));
  EXPECT_THAT(without, HasSubstr("| 100 % | 100 % in "));
  EXPECT_THAT(without, Not(HasSubstr("| rays | "))) << "skipped nowhere";
}

// What is skipped is called by the work and the reason; its share is of the work of the longest name that fits.
TEST_F(Report, PairsSkippedWorkWithTheSameWorkDone) {
  ReportData data = read({.records = 1, .extras = false});
  Record& r = data.records.at(0);
  r.scene = "s";
  r.done = {{"shadow", 1}, {"shadow_rays", 300}, {"shadow_rays_fa", 5}, {"cell", 4}};
  r.skipped = {{"shadow_rays_facing_away", 100}, {"shadow_maps_dark", 1}, {"cells_dark", 7}, {"rays", 6}};
  const std::string markdown = text(data);
  EXPECT_THAT(markdown, HasSubstr("| shadow rays facing away | 300 shadow rays | 100 | 25 % | 25 % in s |"));
  EXPECT_THAT(markdown, HasSubstr("| shadow maps dark | 1 shadow | 1 | 50 % | 50 % in s |"));
  EXPECT_THAT(markdown, HasSubstr("| cells dark | - | 7 | - | - |")) << "whole words: a cell is not cells";
  EXPECT_THAT(markdown, HasSubstr("| rays | - | 6 | - | - |"));
}

TEST_F(Report, ShowsFitsWithTheirTruth) {
  const std::string markdown = text(read());
  EXPECT_THAT(markdown,
              HasSubstr("| sigma\\_a\\_per\\_mm\\[R\\] | 0.032 | 0.0321 | 0.0319 to 0.0323 | +0.31 % | +1.0 |"));
  EXPECT_THAT(markdown, HasSubstr("not identifiable: flat"));
}

TEST_F(Report, PutsBrokenStressRowsFirst) {
  const std::string markdown = text(read());
  EXPECT_THAT(markdown, HasSubstr("1 of 2 functions broke a limit"));
  EXPECT_LT(markdown.find("broken \\<profile\\>"), markdown.find("| fresnel |"));
}

TEST_F(Report, LargeRunsStayUnder25Megabytes) {
  const ReportData data = read({.records = 400, .pictured = 40, .extras = true, .side = 64});
  const std::string html = page(data);
  EXPECT_LT(html.size(), 25'000'000u);
  EXPECT_THAT(html, HasSubstr("record-" + data.records.back().cell)) << "every record is there";
}

/// What stands between `begin` and the next quote, everywhere before the scripts.
std::vector<std::string> values_of(const std::string& html, const std::string& begin) {
  std::vector<std::string> values;
  const std::size_t end = html.find("</main>");
  for (std::size_t at = html.find(begin); at < end; at = html.find(begin, at + 1)) {
    const std::size_t first = at + begin.size();
    values.push_back(html.substr(first, html.find('"', first) - first));
  }
  return values;
}

TEST_F(Report, EveryLinkLeadsToAnAnchorThatExistsOnce) {
  const std::string html = page(read());
  std::map<std::string, int> ids;
  for (const std::string& id : values_of(html, " id=\"")) ++ids[id];
  EXPECT_GT(ids.size(), 60u) << "every record has one";
  for (const auto& [name, count] : ids) EXPECT_EQ(count, 1) << name;
  for (const std::string& link : values_of(html, "href=\"#")) EXPECT_EQ(ids[link], 1) << link;
}

TEST_F(Report, AFolderWithoutRecordsShowsTheRest) {
  test::write_extras(folder_.file("d"), 16);
  const std::string markdown = text(read_report_data(folder_.file("d")));
  EXPECT_THAT(markdown, HasSubstr("There are no records"));
  EXPECT_THAT(markdown, HasSubstr("fresnel"));
}

TEST_F(Report, ACutLastLineIsLeftOutAndSaid) {
  read({.records = 5, .pictured = 0, .extras = false});
  std::ofstream(folder_.file("d/records.jsonl"), std::ios::app) << "{\"format\": \"opaline-rec";
  const ReportData data = read_report_data(folder_.file("d"));
  EXPECT_EQ(data.records.size(), 5u);
  EXPECT_THAT(text(data), HasSubstr("is unfinished"));
}

TEST_F(Report, CommandWritesAllThreeFiles) {
  read();
  EXPECT_EQ(run("d --out r.html --markdown r.md --csv r.csv"), 0) << err_;
  for (const char* name : {"r.html", "r.md", "r.csv"}) EXPECT_GT(std::filesystem::file_size(folder_.file(name)), 1000u);
}

TEST_F(Report, CommandNamesWhatIsWrong) {
  std::filesystem::create_directories(folder_.file("empty"));
  folder_.write("file", "x");
  expect_wrong("nowhere --out r.html", "nowhere: the folder does not exist");
  expect_wrong("file --out r.html", "file: is a file, not a folder");
  expect_wrong("empty --out r.html", "empty: holds nothing to report");
  expect_wrong("empty", "nothing to write: give --out FILE.html");
  expect_wrong("empty --out r.txt", ".html");
  const auto broken = [&](const std::string& name, const std::string& bytes, const std::string& message) {
    std::filesystem::remove_all(folder_.file("d"));
    read({.records = 3, .pictured = 0, .extras = false});
    test::write_text(folder_.file("d/" + name), bytes);
    expect_wrong("d --out r.html", message);
  };
  broken("records.jsonl", "not json\n{}\n", "records.jsonl: line 1: is not valid JSON");
  broken("records.jsonl", "{\"format\": \"other\"}\n", "records.jsonl: line 1");
  broken("stress.json", "{", "stress.json");
  broken("stress.json", "[]", "stress.json: /functions: must be an array");
  broken("gates.json", "{\"gates\": [1]}", "gates.json: /gates: must hold objects");
  broken("fits/x/fit.json", "{}", "fit.json: /parameters: is missing");
}

}  // namespace
}  // namespace opaline
