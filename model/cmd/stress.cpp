#include "model/stress/stress.h"
#include "model/cmd/commands.h"
#include "model/cmd/exit_status.h"
#include "model/cmd/medium_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity: null.
Json to_json(const WorstCase& worst) {
  return {{"value", worst.value}, {"condition", worst.condition}, {"at", worst.at}};
}

Json to_json(const StressResult& r) {
  return {{"name", r.name},
          {"derivative", r.derivative},
          {"domain", r.domain},
          {"inputs", r.inputs},
          {"points", r.points},
          {"points_below_1e-280", r.dark},
          {"worst_ulp_per_condition", to_json(r.scaled)},
          {"worst_ulp", to_json(r.plain)},
          {"limit", r.limit},
          {"checked", r.checked},
          {"nan", r.nan},
          {"infinite", r.infinite},
          {"negative", r.negative},
          {"not_monotone", r.not_monotone},
          {"first_invalid_at", r.invalid_at},
          {"passed", r.passed()}};
}

std::string place(const StressResult& r, const std::vector<double>& at) {
  std::string text;
  for (std::size_t i = 0; i < at.size(); ++i) text += fmt::format("{}{} {:.17g}", i ? ", " : "", r.inputs[i], at[i]);
  return text;
}

void print_row(const StressResult& r) {
  const std::string compared = r.points == 0 ? fmt::format("{:>7} {:>10} {:>7} {:>10}", "-", "-", "-", "-")
                                             : fmt::format("{:>7} {:>10.3g} {:>7.4g} {:>10.3g}", r.points,
                                                           r.scaled.value, r.limit, r.plain.value);
  fmt::print("{:<46} {} {:>9} {:>4} {:>4} {:>4} {:>4}  {}\n", (r.derivative ? "d " : "") + r.name, compared, r.checked,
             r.nan, r.infinite, r.negative, r.not_monotone, r.passed() ? "ok" : "FAILED");
  if (!r.scaled.at.empty())
    fmt::print("    worst/(1+condition) at {}; condition {:.3g}\n", place(r, r.scaled.at), r.scaled.condition);
  if (!r.plain.at.empty())
    fmt::print("    worst ULP at {}; condition {:.3g}\n", place(r, r.plain.at), r.plain.condition);
  if (!r.invalid_at.empty()) fmt::print("    invalid first at {}\n", place(r, r.invalid_at));
}

void print_table(const std::vector<StressResult>& results) {
  fmt::print("{:<46} {:>7} {:>10} {:>7} {:>10} {:>9} {:>4} {:>4} {:>4} {:>4}\n", "function (d: its derivatives)",
             "points", "ULP/(1+k)", "limit", "worst ULP", "checked", "NaN", "Inf", "neg", "mono");
  for (const StressResult& r : results) print_row(r);
}

void print_json(const StressOptions& o, const std::vector<StressResult>& results) {
  Json json = {{"count", o.count}, {"points", o.points}, {"seed", o.seed}};
  for (const StressResult& r : results) json["functions"].push_back(to_json(r));
  fmt::print("{}\n", json.dump(2));
}

void run(const StressOptions& o, bool json) {
  const std::vector<StressResult> results = run_stress(o);
  require_argument(!results.empty(), fmt::format("--only: no function's name contains \"{}\"; there are {}", o.only,
                                                 fmt::join(stress_function_names(), ", ")));
  json ? print_json(o, results) : print_table(results);
  std::vector<std::string> failed;
  for (const StressResult& r : results) {
    if (!r.passed()) failed.push_back((r.derivative ? "derivatives of " : "") + r.name);
  }
  if (!failed.empty()) throw CommandFailed(fmt::format("past the limits: {}", fmt::join(failed, ", ")));
}

}  // namespace

void add_stress_command(CLI::App& app) {
  const auto o = std::make_shared<StressOptions>();
  const auto json = std::make_shared<bool>(false);
  CLI::App* stress = app.add_subcommand("stress", "Rounding errors and invalid values of every formula");
  stress->add_option("--count", o->count, "Random inputs per function, checked in double alone")->capture_default_str();
  stress->add_option("--points", o->points, "Random inputs per function, compared with 100 digits")
      ->capture_default_str();
  stress->add_option("--only", o->only, "Only functions whose name contains this");
  stress->add_option("--seed", o->seed, "Seed of the random inputs")->capture_default_str();
  stress->add_option("--threads", o->threads, "Use at most this many threads (default: all processors)")
      ->check(CLI::Range(1, 1024));
  stress->add_flag("--json", *json, "JSON, with each function's domain, instead of a table");
  stress->footer(
      "ULP/(1+k): error in units of the last place, divided by 1 + the condition number k of the function at that\n"
      "input; of a float for rows marked (float). Exit code 1 past a limit or for any NaN, infinite, negative or "
      "non-monotone value.\n"
      "Example: opaline stress --count 10000000 --only standard_dipole");
  stress->callback([o, json] { run(*o, *json); });
}

}  // namespace opaline
