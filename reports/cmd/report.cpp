#include "reports/report.h"
#include "render/cmd/render_arguments.h"
#include "render/scene/json_object.h"
#include "reports/cmd/commands.h"
#include "reports/csv.h"
#include "reports/format.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

#include <memory>

namespace opaline {
namespace {

struct Arguments {
  std::string directory, out, markdown, csv;
};

void write(const std::string& path, const std::string& text) {
  if (path.empty()) return;
  write_text_atomically(path, text);
  fmt::print(stderr, "{} ({})\n", path, bytes_text(text.size()));
}

void run(const Arguments& a) {
  if (a.out.empty() && a.markdown.empty() && a.csv.empty())
    throw std::invalid_argument("nothing to write: give --out FILE.html, --markdown FILE.md or --csv FILE.csv");
  check_output_path(a.out, ".html");
  check_output_path(a.markdown, ".md");
  check_output_path(a.csv, ".csv");
  const ReportData data = read_report_data(a.directory);
  write(a.csv, records_csv(data.records));
  if (a.out.empty() && a.markdown.empty()) return;
  const std::vector<Chapter> chapters = write_sections(data);
  if (!a.out.empty()) write(a.out, report_html(chapters, report_title(data)));
  if (!a.markdown.empty()) write(a.markdown, report_markdown(chapters, report_title(data)));
}

}  // namespace

void add_report_command(CLI::App& app) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* report = app.add_subcommand("report", "Results as one HTML file that opens anywhere, as Markdown, as CSV");
  report
      ->add_option("DIR", a->directory,
                   "Folder that `opaline validate --out` wrote; stress.json and fits/ in it are shown")
      ->required();
  report->add_option("--out", a->out, "Page to write (.html): self-contained, under 25 MB");
  report->add_option("--markdown", a->markdown, "The tables as Markdown (.md)");
  report->add_option("--csv", a->csv, "One line per record (.csv)");
  report->footer("Example: opaline report out/quick --out report.html --csv records.csv");
  report->callback([a] { run(*a); });
}

}  // namespace opaline
