#include "validate/cmd/supervise.h"

#include "render/file.h"
#include "render/input_error.h"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <vector>

namespace opaline {
namespace {

/// In a child: the failed cells, as JSON.
constexpr const char* variable = "OPALINE_SUPERVISED";

/// The words this program was called with.
std::vector<std::string> own_arguments() {
  std::vector<std::string> arguments;
  std::istringstream words(read_file("/proc/self/cmdline"));
  for (std::string word; std::getline(words, word, '\0');) arguments.push_back(word);
  return arguments;
}

/// Begins this program anew, with the same arguments; the child dies with this process. Not a mere fork: libraries have
/// threads by now, which a fork would lose.
::pid_t begin_child(const std::map<std::string, std::string>& failed) {
  std::vector<std::string> arguments = own_arguments();
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  ::setenv(variable, nlohmann::json(failed).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace).c_str(), 1);
  std::fflush(nullptr);
  const ::pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) throw MachineError(std::string("no process can be begun: ") + std::strerror(errno));
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() == parent) ::execv("/proc/self/exe", words.data());
    ::_exit(3);
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
  if (const char* known = std::getenv(variable)) {
    const nlohmann::json failed = nlohmann::json::parse(known);
    ::unsetenv(variable);  // a program that this one starts is not supervised
    return work(failed);
  }
  std::map<std::string, std::string> failed;
  for (;;) {
    const int status = wait_for(begin_child(failed));
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
