#include "reports/csv.h"

#include "reports/analysis.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <set>

namespace opaline {
namespace {

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.9g}", value) : ""; }

/// Keys of a map member over all records, sorted.
template <typename Get>
std::vector<std::string> keys_of(const std::vector<Record>& records, Get get) {
  std::set<std::string> keys;
  for (const Record& r : records)
    for (const auto& [key, ignored] : get(r)) keys.insert(key);
  return {keys.begin(), keys.end()};
}

const std::map<std::string, double>& truth_of(const Record& r) {
  static const std::map<std::string, double> none;
  return r.truth_error ? *r.truth_error : none;
}

/// One column: its name and its value in a record, ready to be written.
struct Column {
  std::string name;
  std::function<std::string(const Record&)> value;
};

template <typename Get>
void add_columns(std::vector<Column>& columns, const std::string& prefix, const std::vector<Record>& records, Get get) {
  for (const std::string& key : keys_of(records, get))
    columns.push_back({prefix + key, [key, get](const Record& r) {
                         const auto& map = get(r);
                         const auto it = map.find(key);
                         if (it == map.end()) return std::string();
                         if constexpr (std::is_integral_v<decltype(it->second)>)
                           return std::to_string(it->second);
                         else
                           return number(it->second);
                       }});
}

void add_identity(std::vector<Column>& columns) {
  const auto text = [&](const char* name, std::string Record::*member) {
    columns.push_back({name, [member](const Record& r) { return csv_escaped(r.*member); }});
  };
  text("cell", &Record::cell), text("suite", &Record::suite), text("scene", &Record::scene);
  text("material", &Record::material), text("technique", &Record::technique), text("backend", &Record::backend);
  columns.push_back({"settings", [](const Record& r) { return csv_escaped(settings_text(r)); }});
  columns.push_back({"status", [](const Record& r) { return status_name(r.status); }});
  text("reason", &Record::reason);
}

/// A time that was measured; cells that were not run have none.
void add_time(std::vector<Column>& columns, const char* name, std::function<double(const RecordSeconds&)> get) {
  columns.push_back({std::string("seconds.") + name,
                     [get](const Record& r) { return r.status == CellStatus::done ? number(get(r.seconds)) : ""; }});
}

void add_times(std::vector<Column>& columns) {
  using S = const RecordSeconds&;
  add_time(columns, "prepare.median", [](S s) { return s.prepare.median; });
  add_time(columns, "prepare.min", [](S s) { return s.prepare.min; });
  add_time(columns, "render.median", [](S s) { return s.render.median; });
  add_time(columns, "render.min", [](S s) { return s.render.min; });
  add_time(columns, "render.runs", [](S s) { return s.render.runs; });
  for (const char* edit : {"camera", "light", "material", "geometry"})
    add_time(columns, (std::string("edit.") + edit).c_str(), [edit = std::string(edit)](S s) {
      const auto it = s.edits.find(edit);
      return it == s.edits.end() ? std::nan("") : it->second.total;
    });
  add_time(columns, "harness_overhead", [](S s) { return s.harness_overhead; });
}

void add_origin(std::vector<Column>& columns) {
  columns.push_back({"cpu", [](const Record& r) { return csv_escaped(r.machine.cpu); }});
  columns.push_back({"gl_renderer", [](const Record& r) { return csv_escaped(r.machine.gl_renderer); }});
  columns.push_back({"version", [](const Record& r) { return csv_escaped(r.machine.version); }});
  columns.push_back({"time", [](const Record& r) { return csv_escaped(r.machine.time); }});
  columns.push_back({"seed", [](const Record& r) { return std::to_string(r.seed); }});
  columns.push_back({"command", [](const Record& r) { return csv_escaped(r.command); }});
}

std::vector<Column> all_columns(const std::vector<Record>& records) {
  std::vector<Column> columns;
  add_identity(columns);
  add_times(columns);
  columns.push_back({"peak_rss_bytes", [](const Record& r) { return std::to_string(r.peak_rss_bytes); }});
  add_columns(
      columns, "error.", records, [](const Record& r) -> const auto& { return r.error; });
  add_columns(columns, "truth_error.", records, truth_of);
  columns.push_back({"reference.certified_relative_error",
                     [](const Record& r) { return number(r.reference.certified_relative_error); }});
  add_columns(
      columns, "done.", records, [](const Record& r) -> const auto& { return r.done; });
  add_columns(
      columns, "skipped.", records, [](const Record& r) -> const auto& { return r.skipped; });
  add_origin(columns);
  return columns;
}

}  // namespace

std::string csv_escaped(const std::string& text) {
  std::string out = !text.empty() && std::string("=+-@").find(text.front()) != std::string::npos ? "'" + text : text;
  if (out.find_first_of(",\"\r\n") == std::string::npos) return out;
  for (std::size_t at = out.find('"'); at != std::string::npos; at = out.find('"', at + 2)) out.insert(at, 1, '"');
  return '"' + out + '"';
}

std::string records_csv(const std::vector<Record>& records) {
  const std::vector<Column> columns = all_columns(records);
  std::string text;
  for (const Column& c : columns) text += (text.empty() ? "" : ",") + csv_escaped(c.name);
  text += "\r\n";
  for (const Record& r : records) {
    for (std::size_t i = 0; i < columns.size(); ++i) text += (i ? "," : "") + columns[i].value(r);
    text += "\r\n";
  }
  return text;
}

}  // namespace opaline
