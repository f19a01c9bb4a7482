// The verdict on a run: gates, JUnit, baseline.
#pragma once

#include "validate/gates.h"

#include <string>
#include <vector>

namespace opaline {

struct JudgeOptions {
  std::string gates;     ///< name or file; empty: none
  std::string junit;     ///< file to write; empty: none
  std::string baseline;  ///< folder or file of an earlier run; empty: none
};

class Judge {
 public:
  /// Reads gates and baseline, so that a mistake in them is found before any work. Throws InputError.
  explicit Judge(const JudgeOptions& options);
  /// Prints and writes everything, and only then throws CommandFailed for gates that fell short or a run that is worse
  /// than its baseline. Outcomes of gates go to gates.json in the folder.
  void judge(const std::string& suite, const std::string& folder, const std::vector<Record>& records) const;

 private:
  JudgeOptions options_;
  std::vector<Gate> gates_;
  std::vector<Record> before_;
};

}  // namespace opaline
