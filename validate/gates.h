// Gates: figures of a run that a continuous integration holds to limits. validate.md says what a file of them may
// hold; absolute times are refused, because they are of the machine and not of the program.
#pragma once

#include "validate/record.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace opaline {

/// Which records a figure is taken from: those that agree in everything that is set.
struct RecordSelection {
  std::string scene, material, technique, backend;
  std::map<std::string, std::string> settings;  ///< these and maybe others
};
bool selects(const RecordSelection& selection, const Record& record);

/// One number of each selected record.
struct Figure {
  enum class Kind { error, truth_error, reference, counter, seconds, count };
  Kind kind = Kind::error;
  /// A metric (of mean_error the magnitude counts); "certified_relative_error", "certified_max" or
  /// "truth_standard_error"; "done.NAME" or "skipped.NAME"; "prepare", "render" (the least of their runs, which other
  /// work disturbs least), or "edit.EDIT"; a status ("failed": how many).
  std::string name;
  RecordSelection selection;
};

struct Gate {
  std::string name;
  Figure figure;
  /// Of the records with the same scene and material; of the same technique, with the same settings as well, unless it
  /// names settings.
  std::optional<Figure> divided_by;
  double limit = 0;
  bool upper = true;  ///< value <= limit, else value >= limit
};

struct GateFile {
  std::string path;
  std::vector<Gate> gates;
};

/// Throws InputError naming file, place and valid choices.
GateFile parse_gates(const nlohmann::json& document, const std::string& path);

/// The built-in gates of that name ("quick"), or the file if it ends in ".json".
GateFile find_gates(const std::string& name_or_file);

struct GateResult {
  enum class Outcome { passed, failed, skipped };
  std::string name;
  Outcome outcome = Outcome::passed;
  double value = 0;  ///< the worst of the selected ones
  double limit = 0;
  bool upper = true;
  std::string where;    ///< the record (and its divisor) of that value
  std::string message;  ///< why it failed or was skipped
};

/// A gate fails when its worst value breaks the limit, isn't finite, or when no record is selected; it is skipped when
/// all that are selected are not applicable.
std::vector<GateResult> check_gates(const std::vector<Gate>& gates, const std::vector<Record>& records);

nlohmann::ordered_json to_json(const std::vector<GateResult>& results);

}  // namespace opaline
