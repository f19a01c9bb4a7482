#include "reports/report.h"

#include "reports/html.h"
#include "reports/markdown.h"

#include <fmt/format.h>

#include <set>
#include <string_view>

namespace opaline {
namespace {

/// Files of page/ and the plotting library, built in by embed.cmake.
struct PageFile {
  const char *name, *text;
};
const PageFile page_files[] = {
#include "page.inc"
};

std::string_view page_file(std::string_view name) {
  for (const PageFile& file : page_files)
    if (name == file.name) return file.text;
  return {};
}

/// Source for a <script>: no "</script" may stand in it, not even in a string.
std::string script_source(std::string_view source) {
  std::string out(source);
  for (std::size_t at = out.find("</script"); at != std::string::npos; at = out.find("</script", at))
    out.insert(at + 1, "\\");
  return out;
}

std::string navigation(const std::vector<Chapter>& chapters) {
  std::string text = "<nav aria-label=\"Sections\"><ul>\n";
  for (const Chapter& c : chapters)
    text += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", html_escaped(c.id), html_escaped(c.title));
  return text + "</ul></nav>\n";
}

/// Nothing may be fetched, and nothing but what is written here may run.
constexpr const char* policy =
    "default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

}  // namespace

bool has_plotting_library() { return !page_file("plotly-basic.min.js").empty(); }

std::string report_html(const std::vector<Chapter>& chapters, const std::string& title) {
  std::string page =
      fmt::format(R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="{}">
<title>{}</title>
<style>
{}</style>
</head>
<body>
<a class="skip" href="#main">Skip to the report</a>
<header><h1>{}</h1><button type="button" id="theme">Theme: as the system</button></header>
{}<main id="main">
)",
                  policy, html_escaped(title), page_file("page.css"), html_escaped(title), navigation(chapters));
  for (const Chapter& chapter : chapters) page += html(chapter);
  page += "</main>\n";
  // The page can be read before the scripts, the last in the file, have arrived.
  for (const char* name : {"plotly-basic.min.js", "page.js", "plots.js", "viewer.js"})
    if (!page_file(name).empty()) page += "<script>" + script_source(page_file(name)) + "</script>\n";
  return page + "</body>\n</html>\n";
}

std::string report_markdown(const std::vector<Chapter>& chapters, const std::string& title) {
  std::string text = "# " + markdown_escaped(title) + "\n\n";
  for (const Chapter& chapter : chapters) text += markdown(chapter);
  return text;
}

std::string report_title(const ReportData& data) {
  std::set<std::string> suites;
  for (const Record& r : data.records) suites.insert(r.suite);
  return suites.empty() ? "Opaline report" : fmt::format("Opaline report: {}", fmt::join(suites, ", "));
}

}  // namespace opaline
