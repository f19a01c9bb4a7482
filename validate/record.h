// The record: what one cell of the matrix scene x technique x backend x settings cost and how wrong it was. It is the
// one row type that advice, gates and reports read. One JSON object a line in DIR/records.jsonl, appended as cells
// finish.
//
// Times are wall-clock seconds, sizes bytes, errors in the units metrics/metric.h states. A value that is not finite
// (PSNR of equal images, a relative error against black) is null in the file and infinity here.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace opaline {

/// One thing timed several times, warm: a first run that isn't counted has filled caches and compiled shaders.
struct Timing {
  double median = 0, min = 0;
  int runs = 0;
  std::vector<double> values;  ///< in the order they were measured
};

/// Median, least and count of the values.
Timing make_timing(std::vector<double> values);

/// The first frame after an edit of the scene, measured: total = shared + prepare + render.
struct EditCost {
  double total = 0;
  double shared = 0;   ///< what every technique needs again: rays, view, cells and irradiance, as far as the edit asks
  double prepare = 0;  ///< 0 where Technique::invalidated_by says that what was prepared still holds
  double render = 0;
};

struct RecordSeconds {
  Timing prepare, render;
  double load = 0, gbuffer = 0,
         irradiance = 0;                  ///< made once per scene, when they were made (not when read from cache)
  std::map<std::string, EditCost> edits;  ///< by "camera", "light", "material", "geometry": those the suite asks
  /// What the harness itself took for this cell: all of it but the work above and the metrics.
  double harness_overhead = 0;
};

/// How good the images are that errors are measured against.
struct RecordReference {
  std::map<std::string, std::string> settings;  ///< of the hierarchical reference
  double certified_relative_error = 0;          ///< RMS of the reference's own bound / RMS of the reference
  double certified_max = 0;                     ///< largest bound of a pixel [radiance]
  double seconds = 0;                           ///< to make it
  double truth_standard_error = 0;              ///< RMS standard error of a pixel of the truth / RMS of the truth
  double truth_seconds = 0;
};

/// Where and with what it was measured.
struct RecordMachine {
  std::string cpu;
  int cores = 0;
  std::string gl_renderer;  ///< of a gpu cell; says so where it is a software renderer
  std::string version, compiler;
  std::string program;  ///< hash of the program's own file: another build is another program
  std::string time;     ///< ISO 8601, UTC
};

enum class CellStatus { done, not_applicable, failed };

struct Record {
  std::string cell;  ///< hash of everything that determines the cell: scene, technique, settings, program
  std::string suite, scene, material, technique, backend;
  std::map<std::string, std::string> settings;   ///< those the sweep set; defaults are not repeated
  std::uint64_t film_pixels = 0;                 ///< width * height
  std::uint64_t samples = 0, light_samples = 0;  ///< surface cells; directions of each towards extended lights
  CellStatus status = CellStatus::done;
  std::string reason;  ///< of a cell that is not applicable or failed; of a done one without `error`, why there is none
  RecordSeconds seconds;
  std::uint64_t peak_rss_bytes = 0;  ///< of the process by the end of the cell
  /// By metric name, against the hierarchical reference; empty unless done, or where no reference applies.
  std::map<std::string, double> error;
  /// The same against path_traced, which has its own noise; absent where the suite doesn't ask for it.
  std::optional<std::map<std::string, double>> truth_error;
  RecordReference reference;
  std::map<std::string, std::uint64_t> done, skipped;  ///< counters of prepare and one frame
  /// By "render", "reference", "bound", "truth", "variance": files relative to the folder of the records.
  std::map<std::string, std::string> images;
  RecordMachine machine;
  std::uint64_t seed = 0;
  std::string command;  ///< makes the same image again

  /// "scene/material technique/backend key=value ...": two records of one name are measurements of one cell.
  std::string name() const;
};

/// "done", "not_applicable", "failed".
std::string status_name(CellStatus status);

nlohmann::ordered_json to_json(const Record& record);

/// Throws InputError(file, place) for a document that is no record of this version; keys it doesn't know are left
/// alone, keys that are missing have their default.
Record record_from_json(const nlohmann::json& json, const std::string& file, const std::string& place);

/// A file of records, and what was wrong with it that does no harm.
struct RecordFile {
  std::vector<Record> records;  ///< in the order of the file; of several with one name the last alone
  std::size_t superseded = 0;   ///< earlier measurements of a cell that were left out
  bool cut = false;             ///< the last line is not whole: the run that wrote it was killed there
};

/// Reads a records.jsonl. Throws InputError for a missing file, and, naming the line, for a line that is no record; the
/// last line may be cut, which is reported in `cut` (only a cell that was being written is lost by that).
RecordFile read_records(const std::string& path);

/// Appends lines to a records.jsonl; each is on disk when `append` returns (flushed and synchronised).
class RecordWriter {
 public:
  /// Makes the file if it's missing; cuts off a last line that is not whole, as read_records leaves it out. Throws
  /// InputError.
  explicit RecordWriter(const std::string& path);
  ~RecordWriter();
  RecordWriter(const RecordWriter&) = delete;
  RecordWriter& operator=(const RecordWriter&) = delete;
  void append(const Record& record);

 private:
  std::string path_;
  int file_ = -1;
};

}  // namespace opaline
