// Arguments and outputs that several commands share.
#pragma once

#include "render/render_scene.h"

#include <tbb/global_control.h>
#include <CLI/CLI.hpp>

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace opaline {

/// --threads N, 1 .. 1024; `threads` stays 0 (all processors) without it.
void add_threads_option(CLI::App& command, int& threads);

/// At most that many threads work while the result lives; 0: no limit, null.
std::unique_ptr<tbb::global_control> limit_threads(int threads);

/// "key=value" texts of an option as a map. Throws std::invalid_argument for one without "=" or a key given twice.
std::map<std::string, std::string> parse_assignments(const std::vector<std::string>& texts,
                                                     const std::string& option = "--set");

/// Throws InputError unless `path` ends in `extension` and its folder exists; an empty path is fine.
/// Called before the work, so that an hour's image isn't lost to a misspelt folder.
void check_output_path(const std::string& path, const std::string& extension);

/// The technique and its settings for people: name, summary, citation, backends, limits, each setting.
std::string describe_techniques();

/// A line on stderr with the stage of the work and a bar; silent unless stderr is a terminal.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();  ///< clears the line
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  void show(const std::string& stage);

 private:
  void draw(double fraction) const;
  bool terminal_;
  std::string stage_;
};

}  // namespace opaline
