#include "render/input_error.h"
#include "validate/advice.h"
#include "validate/cmd/commands.h"

#include <fmt/format.h>

#include <algorithm>

namespace opaline {
namespace {

std::string describe(const Way& way) {
  std::string text = way.technique + " on the " + way.backend;
  for (const auto& [key, value] : way.settings) text += fmt::format(", {}={}", key, value);
  return text;
}

std::string figures(const Way& way) {
  return fmt::format("relative_rmse at most {:.3g} on {} measured scenes (worst: {}), about {:.3g} ms for this film",
                     way.worst_error, way.scenes, way.worst_scene, 1e3 * way.expected_seconds);
}

[[noreturn]] void none_keeps(const ChoiceRequest& request, std::vector<Way> all) {
  if (all.empty())
    throw InputError(request.records, "",
                     "has no technique with an error on every measured scene that it can render" +
                         (request.backend.empty() ? std::string() : " on the backend " + request.backend));
  const bool by_error = request.max_error.has_value();
  const Way& nearest = *std::min_element(all.begin(), all.end(), [&](const Way& a, const Way& b) {
    return by_error ? a.worst_error < b.worst_error : a.expected_seconds < b.expected_seconds;
  });
  throw InputError(
      request.records, "",
      fmt::format("nothing measured keeps the limit; nearest is {}: {}", describe(nearest), figures(nearest)));
}

}  // namespace

std::vector<TechniqueChoice> choose_from_records(const ChoiceRequest& request) {
  std::vector<Way> all = ways(read_records(request.records + "/records.jsonl").records, request.pixels);
  if (!request.backend.empty()) std::erase_if(all, [&](const Way& way) { return way.backend != request.backend; });
  const std::vector<Way> kept = request.max_error ? fastest_within_error(all, *request.max_error)
                                                  : most_accurate_within(all, *request.budget_seconds);
  if (kept.empty()) none_keeps(request, all);
  std::vector<TechniqueChoice> choices;
  for (const Way& way : kept) {
    const std::string why = fmt::format("{}: the {} of {} ways that keep the limit of {}: {}", describe(way),
                                        request.max_error ? "fastest" : "most accurate", kept.size(),
                                        request.max_error ? fmt::format("relative_rmse {:g}", *request.max_error)
                                                          : fmt::format("{:g} ms", 1e3 * *request.budget_seconds),
                                        figures(way));
    choices.push_back({way.technique, way.backend, way.settings, static_cast<std::size_t>(way.samples), why});
  }
  return choices;
}

}  // namespace opaline
