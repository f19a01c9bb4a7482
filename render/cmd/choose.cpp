#include "render/cmd/choose.h"

#include "render/input_error.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace opaline {

void add_choice_options(CLI::App& command, ChoiceRequest& request) {
  command.add_option(
      "--max-error", request.max_error,
      "Instead of --technique: the fastest whose relative_rmse was at most this wherever it was measured");
  command.add_option_function<double>(
      "--budget", [&request](double milliseconds) { request.budget_seconds = milliseconds / 1000; },
      "Instead of --technique: the most accurate that takes at most this long [ms]");
  command.add_option("--records", request.records, "Folder of `opaline validate` to choose from");
}

bool asks_for_choice(const ChoiceRequest& request) { return request.max_error || request.budget_seconds; }

void check_choice_request(const ChoiceRequest& request, const RenderOptions& options) {
  if (request.max_error && request.budget_seconds)
    throw std::invalid_argument("--max-error and --budget: give one of the two");
  if (!options.technique.empty() || !options.settings.empty())
    throw std::invalid_argument(
        "--max-error and --budget choose the technique and its settings: leave out --technique "
        "and --set");
  if (request.records.empty())
    throw std::invalid_argument("--records: name the folder of an `opaline validate` run to choose from");
  const double limit = request.max_error.value_or(request.budget_seconds.value_or(0));
  if (!(limit > 0) || !std::isfinite(limit)) throw std::invalid_argument("--max-error and --budget must be > 0");
}

void choose_technique(const Scene& scene, ChoiceRequest request, const TechniqueChooser& chooser,
                      RenderOptions& options) {
  request.backend = options.backend;
  request.pixels = static_cast<double>(scene.film.width) * scene.film.height;
  std::string unfit;
  for (const TechniqueChoice& choice : chooser(request)) {
    const std::string reason = why_not_applicable(find_technique(choice.technique), scene);
    if (!reason.empty()) {
      unfit += fmt::format("; {}: {}", choice.technique, reason);
      continue;
    }
    options.technique = choice.technique;
    options.backend = choice.backend;
    options.settings = choice.settings;
    options.shared.samples = choice.samples > 0 ? choice.samples : options.shared.samples;
    fmt::print(stderr, "opaline: {}\n", choice.why);
    return;
  }
  throw InputError(request.records, "", "none of the techniques that keep the limit can render this scene" + unfit);
}

}  // namespace opaline
