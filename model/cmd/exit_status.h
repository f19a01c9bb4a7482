// How a command ends: 0 done; 1 a comparison or gate failed; 2 the input or the arguments are wrong;
// 3 the machine lacks something. Callbacks of subcommands throw, the main program makes the code.
#pragma once

#include <stdexcept>

namespace opaline {

enum ExitStatus { exit_done = 0, exit_failed = 1, exit_wrong_input = 2, exit_machine = 3 };

/// A comparison or gate failed: exit code 1. `what()` names the value and the limit it broke.
class CommandFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace opaline
