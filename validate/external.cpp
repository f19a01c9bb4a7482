#include "validate/external.h"

#include "render/file.h"
#include "render/stopwatch.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

extern char** environ;

namespace opaline {
namespace {

namespace fs = std::filesystem;

/// In single quotes, as a shell takes it for one word.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

/// Starts the command with its output in a file.
::pid_t start(const std::string& command, const std::string& log) {
  const char* arguments[] = {"/bin/sh", "-c", command.c_str(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  ::pid_t child = 0;
  const int error = posix_spawn(&child, arguments[0], &actions, nullptr, const_cast<char**>(arguments), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error(std::string("/bin/sh cannot be started: ") + std::strerror(error));
  return child;
}

std::string how_it_ended(int status) {
  if (WIFEXITED(status)) return fmt::format("ended with exit code {}", WEXITSTATUS(status));
  return fmt::format("was ended by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)));
}

/// The last lines of the output, for a message.
std::string tail(const std::string& log) {
  std::string text = read_file(log);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.size() <= 400 ? text : "..." + text.substr(text.size() - 400);
}

}  // namespace

ExternalRun run_external(const std::string& command, const std::string& folder, const std::string& scene,
                         const std::string& stem) {
  const std::string base = fs::absolute(folder).lexically_normal().string();
  const std::string out = base + "/images/" + stem + ".external.exr", log = base + "/images/" + stem + ".log";
  fs::remove(out);
  ExternalRun run;
  run.command = replaced(replaced(command, "{scene}", quoted(base + "/" + scene)), "{out}", quoted(out));
  Stopwatch watch;
  const ::pid_t child = start(run.command, log);
  int status = 0;
  rusage usage{};
  while (::wait4(child, &status, 0, &usage) < 0)
    if (errno != EINTR) throw std::runtime_error("the command was lost");
  run.seconds = watch.lap();
  run.peak_rss_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  if (status != 0) throw std::runtime_error(fmt::format("the command {}: {}", how_it_ended(status), tail(log)));
  if (!fs::exists(out)) throw std::runtime_error(fmt::format("the command wrote no {}: {}", out, tail(log)));
  run.image = read_image(out);
  fs::remove(out);
  fs::remove(log);
  return run;
}

}  // namespace opaline
