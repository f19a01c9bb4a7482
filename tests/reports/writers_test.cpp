// HTML, Markdown and CSV: what is escaped, and that nothing gets lost.
#include "reports/csv.h"
#include "reports/format.h"
#include "reports/html.h"
#include "reports/markdown.h"
#include "tests/support/report_fixture.h"

#include <gmock/gmock.h>

#include <limits>

namespace opaline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Html, EscapesWhatCouldBeMarkup) {
  EXPECT_EQ(html_escaped("<script>alert('x' & \"y\")</script>"),
            "&lt;script&gt;alert(&#39;x&#39; &amp; &quot;y&quot;)&lt;/script&gt;");
  EXPECT_EQ(html_escaped("µ ≤ 1"), "µ ≤ 1");
  EXPECT_EQ(html_escaped(std::string("a\0b\x01", 4)),
            "a\xEF\xBF\xBD"
            "b\xEF\xBF\xBD");
  EXPECT_EQ(html_escaped("\xff!"), "\xEF\xBF\xBD!") << "not UTF-8";
}

TEST(Html, JsonCannotEndItsScript) {
  const std::string text = script_json({{"name", "</script><b>"}});
  EXPECT_THAT(text, Not(HasSubstr("<")));
  EXPECT_EQ(nlohmann::json::parse(text)["name"], "</script><b>");
}

TEST(Html, EveryCellIsEscapedAndTheFirstNamesItsRow) {
  TableCell linked("<t>");
  linked.link = "a\"b";
  const std::string text =
      html(Table{"<title>", {"<h>", "n"}, {{"<r>", number_cell("<1>")}, {linked, reason_cell("")}}, false});
  for (const char* raw : {"<title>", "<h>", "<r>", "<1>", "<t>", "a\"b"}) EXPECT_THAT(text, Not(HasSubstr(raw)));
  EXPECT_THAT(text, HasSubstr("<th scope=\"row\">&lt;r&gt;</th><td class=\"n\">&lt;1&gt;</td>"));
  EXPECT_THAT(text, HasSubstr("no reason was recorded")) << "a cell is never empty";
}

TEST(Markdown, EscapesWhatWouldBeMarkup) {
  EXPECT_EQ(markdown_escaped("a|b *c* _d_ <e>\nf"), "a\\|b \\*c\\* \\_d\\_ \\<e\\> f");
  TableCell command = code_cell("opaline `x` | y");
  const std::string text = markdown(Block(Table{"t", {"h", "n"}, {{command, number_cell("1")}}, false}));
  EXPECT_EQ(text, "**t**\n\n| h | n |\n| --- | ---: |\n| `opaline 'x' \\| y` | 1 |\n\n");
}

TEST(Csv, QuotesByRfc4180) {
  EXPECT_EQ(csv_escaped("plain"), "plain");
  EXPECT_EQ(csv_escaped("a,\"b\"\nc"), "\"a,\"\"b\"\"\nc\"");
  EXPECT_EQ(csv_escaped("=SUM(A1)"), "'=SUM(A1)") << "no formula";
}

/// Reads CSV back, independently of the writer.
std::vector<std::vector<std::string>> parsed(const std::string& text) {
  std::vector<std::vector<std::string>> rows(1, {""});
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"')
      rows.back().back() += text[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && c == ',')
      rows.back().emplace_back();
    else if (!quoted && c == '\r')
      ++i, rows.push_back({""});
    else
      rows.back().back() += c;
  }
  rows.pop_back();
  return rows;
}

TEST(Csv, HoldsEveryRecordAndNumber) {
  auto records = test::made_up_records(30);
  records[0].error["psnr"] = std::numeric_limits<double>::infinity();
  records[0].reason = "a, \"b\"\r\nc";
  const auto rows = parsed(records_csv(records));
  ASSERT_EQ(rows.size(), 31u);
  std::map<std::string, std::size_t> column;
  for (std::size_t i = 0; i < rows[0].size(); ++i) column[rows[0][i]] = i;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Record& r = records[i];
    ASSERT_EQ(rows[i + 1].size(), rows[0].size());
    const auto value = [&](const char* name) { return rows[i + 1].at(column.at(name)); };
    EXPECT_EQ(value("scene"), r.scene);
    EXPECT_EQ(value("command"), r.command);
    EXPECT_EQ(value("status"), status_name(r.status));
    if (r.status != CellStatus::done) {
      EXPECT_EQ(value("seconds.render.median"), "") << "what wasn't measured is empty, not 0";
      EXPECT_EQ(value("error.relative_rmse"), "");
      continue;
    }
    EXPECT_NEAR(std::stod(value("error.relative_rmse")), r.error.at("relative_rmse"), 1e-8);
    EXPECT_NEAR(std::stod(value("seconds.render.median")), r.seconds.render.median, 1e-8);
    EXPECT_EQ(value("skipped.samples"), std::to_string(r.skipped.at("samples")));
  }
  EXPECT_EQ(rows[1].at(column.at("error.psnr")), "") << "infinite";
  EXPECT_EQ(rows[1].at(column.at("reason")), "a, \"b\"\r\nc");
}

TEST(Format, NumbersReadEasily) {
  EXPECT_EQ(seconds_text(1.2345), "1.23 s");
  EXPECT_EQ(seconds_text(0.0456), "45.6 ms");
  EXPECT_EQ(seconds_text(123.4), "123 s");
  EXPECT_EQ(seconds_text(7.89e-6), "7.89 µs");
  EXPECT_EQ(relative_text(0.01234), "1.23 %");
  EXPECT_EQ(relative_text(1.2e-5), "1.2e-05");
  EXPECT_EQ(relative_text(std::nan("")), "not finite");
  EXPECT_EQ(count_text(1'234'567), "1.23 M");
  EXPECT_EQ(bytes_text(123'456'789), "123 MB");
}

}  // namespace
}  // namespace opaline
