// The published schema of suites and the reader tell the same story.
#include "tests/validate/validate_fixture.h"
#include "validate/suite.h"

#include <gtest/gtest.h>

#include <sstream>

#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

namespace opaline {
namespace {

using nlohmann::json;
const std::string folder = std::string(OPALINE_SOURCE_DIR) + "/validate/suites/";

bool schema_accepts(const json& document) {
  const json text = read_json_file(folder + "suite.schema.json");
  valijson::Schema schema;
  valijson::SchemaParser(valijson::SchemaParser::kDraft7)
      .populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
  return valijson::Validator(valijson::Validator::kStrongTypes)
      .validate(schema, valijson::adapters::NlohmannJsonAdapter(document), nullptr);
}

bool reader_accepts(const json& document) {
  try {
    parse_suite(document, folder + "s.json");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

TEST(SuiteSchema, AcceptsTheShippedSuites) {
  for (const std::string& name : shipped_suite_names()) {
    EXPECT_TRUE(schema_accepts(read_json_file(folder + name + ".json"))) << name;
    EXPECT_EQ(read_json_file(folder + name + ".json").at("name"), name);
  }
}

TEST(SuiteSchema, AgreesWithTheReader) {
  const std::pair<const char*, json> edits[] = {{"/summary", "words"},
                                                {"/nothing", 1},
                                                {"/name", "a b"},
                                                {"/scenes", json::array()},
                                                {"/scenes/0/recipe", "bust_skin1"},
                                                {"/scenes/0/nothing", 1},
                                                {"/techniques", "all"},
                                                {"/sweeps/hierarchical/0/max_relative_error", json::array()},
                                                {"/techniques", "most"},
                                                {"/backends", {"tpu"}},
                                                {"/edits", {"light", "light"}},
                                                {"/edits", {"light", "camera"}},
                                                {"/samples", 0},
                                                {"/samples", 1.5},
                                                {"/runs", 7},
                                                {"/runs", 0},
                                                {"/max_seconds", 0},
                                                {"/max_seconds", 2.5},
                                                {"/truth", {{"paths", 1}}},
                                                {"/truth", {{"paths", 2}}},
                                                {"/truth", json::object()},
                                                {"/images", "yes"},
                                                {"/images", false},
                                                {"/materials", {{{"library", "skin1"}}}},
                                                {"/materials", {"skin1"}},
                                                {"/sweeps/hierarchical", json::array()},
                                                {"/reference", {{"quality", 0.1}}}};
  for (const auto& [pointer, value] : edits) {
    json document = test::tiny_suite();
    document[json::json_pointer(pointer)] = value;
    EXPECT_EQ(schema_accepts(document), reader_accepts(document)) << pointer << " " << value;
  }
}

}  // namespace
}  // namespace opaline
