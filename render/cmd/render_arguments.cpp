#include "render/cmd/render_arguments.h"

#include "render/choices.h"
#include "render/input_error.h"
#include "render/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <stdexcept>

namespace opaline {
namespace {

namespace fs = std::filesystem;

std::string describe(const SettingSpec& setting) {
  const std::string valid = setting.text              ? "any text"
                            : setting.choices.empty() ? fmt::format("{} to {}", setting.lo, setting.hi)
                                                      : join_names(setting.choices);
  return fmt::format("    --set {}={}\n        {} ({})\n", setting.key, setting.fallback, setting.meaning, valid);
}

std::string materials_of(const Technique& technique) {
  std::vector<std::string> names;
  for (const MaterialKind kind : technique.materials) names.push_back(name_of(kind));
  return join_names(names);
}

std::string describe(const Technique& technique) {
  std::string text =
      fmt::format("{}: {}\n    {}\n    backends: {}; materials: {}; limits: {}\n", technique.name, technique.summary,
                  technique.citation, join_names(technique.backends), materials_of(technique), technique.limits);
  for (const SettingSpec& setting : technique.settings) text += describe(setting);
  return text;
}

}  // namespace

void add_threads_option(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "Use at most this many threads, 1 to 1024 (default: all processors)")
      ->check(CLI::Range(1, 1024));
}

std::unique_ptr<tbb::global_control> limit_threads(int threads) {
  if (threads < 1) return nullptr;
  return std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                               static_cast<std::size_t>(threads));
}

std::map<std::string, std::string> parse_assignments(const std::vector<std::string>& texts, const std::string& option) {
  std::map<std::string, std::string> assignments;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw std::invalid_argument(fmt::format("{}: \"{}\" is not key=value", option, text));
    if (!assignments.emplace(text.substr(0, equals), text.substr(equals + 1)).second)
      throw std::invalid_argument(fmt::format("{}: \"{}\" is given twice", option, text.substr(0, equals)));
  }
  return assignments;
}

void check_output_path(const std::string& path, const std::string& extension) {
  if (path.empty()) return;
  const fs::path file(path);
  if (file.extension() != extension) throw InputError(path, "", "cannot be written: the name must end in " + extension);
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    throw InputError(path, "", fmt::format("cannot be written: the folder \"{}\" does not exist", folder.string()));
}

std::string describe_techniques() {
  std::string text;
  for (const Technique& technique : techniques()) text += (text.empty() ? "" : "\n") + describe(technique);
  return text;
}

ProgressLine::ProgressLine() : terminal_(::isatty(STDERR_FILENO) == 1) {
  if (terminal_) listen_to_progress([this](double fraction) { draw(fraction); });
}

ProgressLine::~ProgressLine() {
  if (!terminal_) return;
  listen_to_progress({});
  std::fputs("\r\033[K", stderr);
}

void ProgressLine::show(const std::string& stage) {
  stage_ = stage;
  if (terminal_) std::fprintf(stderr, "\r\033[K%s ...", stage.c_str());
}

void ProgressLine::draw(double fraction) const {
  constexpr int width = 30;
  const int full = static_cast<int>(fraction * width);
  std::fprintf(stderr, "\r\033[K%s [%s%s] %3.0f %%", stage_.c_str(),
               std::string(static_cast<std::size_t>(full), '#').c_str(),
               std::string(static_cast<std::size_t>(width - full), '.').c_str(), 100 * fraction);
}

}  // namespace opaline
