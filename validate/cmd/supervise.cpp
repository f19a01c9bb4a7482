#include "validate/cmd/supervise.h"

#include "render/file.h"
#include "render/input_error.h"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>

namespace opaline {
namespace {

/// The child's pid in the parent, 0 in the child, which dies with its parent.
::pid_t begin_child() {
  std::fflush(nullptr);
  const ::pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) throw MachineError(std::string("no process can be begun: ") + std::strerror(errno));
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);  // it died before that took hold
  }
  return child;
}

int wait_for(::pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

void supervise(const std::string& marker, const std::function<void(const std::map<std::string, std::string>&)>& work) {
  std::map<std::string, std::string> failed;
  for (;;) {
    const ::pid_t child = begin_child();
    if (child == 0) return work(failed);
    const int status = wait_for(child);
    if (WIFEXITED(status)) ::_exit(WEXITSTATUS(status));
    const int signal = WTERMSIG(status);
    std::error_code ignored;
    const bool at_a_cell = std::filesystem::exists(marker, ignored);
    const std::string cell = at_a_cell ? read_file(marker) : "";
    if (signal == SIGINT || signal == SIGTERM || !at_a_cell || failed.count(cell)) {
      ::signal(signal, SIG_DFL);
      ::raise(signal);
      ::_exit(128 + signal);
    }
    failed[cell] = fmt::format("the program was ended by signal {} ({}) in this cell{}", signal, strsignal(signal),
                               signal == SIGKILL ? ": out of memory?" : "");
    fmt::print(stderr, "opaline: {}; going on with the next\n", failed[cell]);
  }
}

}  // namespace opaline
