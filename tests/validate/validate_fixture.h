// A suite that is measured in a moment, for the tests of running one.
#pragma once

#include "tests/render/scene_fixture.h"
#include "validate/matrix.h"

namespace opaline::test {

/// Two tiny scenes, the sum and the clusters on the processor.
inline nlohmann::json tiny_suite() {
  nlohmann::json scene = valid_document();
  scene["film"] = {{"width", 10}, {"height", 10}};
  scene["camera"]["fov_y_deg"] = 11;
  nlohmann::json second = scene;
  second["lights"][0]["direction"] = {-1, 0, -1};
  return {{"format", "opaline-suite"},
          {"version", 1},
          {"name", "tiny"},
          {"scenes",
           {{{"name", "front"}, {"scene", scene}, {"materials", {"skin1", "wholemilk"}}},
            {{"name", "side"}, {"scene", second}}}},
          {"techniques", {"brute_force", "hierarchical"}},
          {"backends", {"cpu"}},
          {"sweeps", {{"hierarchical", {{{"max_relative_error", {"1e-1", "1e-3"}}, {"discretisation", "fixed"}}}}}},
          {"reference", {{"max_relative_error", "1e-5"}, {"discretisation", "fixed"}}},
          {"samples", 100},
          {"runs", 2},
          {"max_seconds", 0.02}};
}

inline RunSummary run_tiny(const TempFolder& folder, const nlohmann::json& suite = tiny_suite(), bool again = false) {
  RunOptions options;
  options.folder = folder.file("out");
  options.remeasure = again;
  static const ShapeLibrary shapes = test_shapes();
  return run_suite(parse_suite(suite, "tiny.json"), options, shapes);
}

}  // namespace opaline::test
