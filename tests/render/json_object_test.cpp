#include "render/scene/json_object.h"

#include "render/choices.h"
#include "tests/render/scene_fixture.h"

#include <gmock/gmock.h>

#include <limits>

namespace opaline {
namespace {

using nlohmann::json;
using test::message_of;
using test::TempFolder;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const double infinity = std::numeric_limits<double>::infinity();

JsonObject view(const json& value) { return JsonObject(value, "f.json", "/camera"); }

TEST(Range, ExcludesExactlyItsOpenEndsAndWhatIsNotFinite) {
  EXPECT_FALSE(Range::positive().contains(0));
  EXPECT_TRUE(Range::non_negative().contains(0));
  EXPECT_TRUE((Range{-1, 1, true, false}.contains(1)));
  EXPECT_FALSE((Range{-1, 1, true, false}.contains(-1)));
  EXPECT_FALSE(Range::any().contains(infinity));
  EXPECT_FALSE(Range::any().contains(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ((Range{-1, 1, true, false}.describe()), "a number > -1 and <= 1");
}

TEST(JsonObject, ReadsEveryKindOfValue) {
  const json value = json::parse(R"({"n": 1.5, "i": 7.0, "b": true, "t": "x", "v": [1, 2, 3], "c": 4,
                                      "o": {"k": 1}, "l": [{"k": 1}, {"k": 2}], "m": {"a": {}, "b": {}}})");
  JsonObject object = view(value);
  EXPECT_EQ(object.number("n", Range::any()), 1.5);
  EXPECT_EQ(object.number_or("absent", Range::any(), 9), 9);
  EXPECT_EQ(object.integer("i", 0, 10), 7);
  EXPECT_EQ(object.integer_or("absent", 0, 10, 3), 3);
  EXPECT_TRUE(object.boolean_or("b", false));
  EXPECT_EQ(object.text("t"), "x");
  EXPECT_EQ(object.choice_or("absent", {"p", "q"}, "q"), "q");
  EXPECT_EQ(object.vec3("v"), glm::dvec3(1, 2, 3));
  EXPECT_EQ(object.rgb("v", Range::any()), glm::dvec3(1, 2, 3));
  EXPECT_EQ(object.rgb("c", Range::any()), glm::dvec3(4));
  EXPECT_EQ(object.object("o").pointer(), "/camera/o");
  EXPECT_EQ(object.objects("l").at(1).pointer(), "/camera/l/1");
  EXPECT_EQ(object.members("m").at(1).first, "b");
  EXPECT_EQ(object.members("m").at(1).second.pointer(), "/camera/m/b");
  EXPECT_NO_THROW(object.finish());
}

TEST(JsonObject, UnknownKeyListsTheKnownOnesAndTheNearest) {
  const json value = {{"fov_y_deg", 1}, {"fov_y_dge", 2}};
  JsonObject object = view(value);
  object.number("fov_y_deg", Range::any());
  object.has("up");
  EXPECT_EQ(message_of([&] { object.finish(); }),
            "f.json: /camera: unknown key \"fov_y_dge\"; did you mean \"fov_y_deg\"? valid keys: fov_y_deg, up");
}

TEST(JsonObject, FarUnknownKeyGetsNoSuggestion) {
  const json value = {{"zoom", 1}};
  JsonObject object = view(value);
  object.has("up");
  EXPECT_THAT(message_of([&] { object.finish(); }), AllOf(HasSubstr("valid keys: up"), Not(HasSubstr("did you mean"))));
}

TEST(JsonObject, MissingKeyNamesItsMisspelling) {
  const json value = {{"hieght", 20}};
  JsonObject object = view(value);
  EXPECT_EQ(message_of([&] { object.number("height", Range::positive()); }),
            "f.json: /camera: the key \"height\" is missing; did you mean it by \"hieght\"?");
}

TEST(JsonObject, BadValuesNamePlaceRangeAndValue) {
  const json value = {{"n", -3},  {"t", 5},          {"v", {1, 2, "x"}}, {"w", {1, 2}},
                      {"i", 1.5}, {"inf", infinity}, {"a/b", 1}};
  JsonObject object = view(value);
  EXPECT_EQ(message_of([&] { object.number("n", Range::positive()); }),
            "f.json: /camera/n: must be a number > 0, but is -3");
  EXPECT_EQ(message_of([&] { object.text("t"); }), "f.json: /camera/t: must be a text in quotes, but is 5");
  EXPECT_EQ(message_of([&] { object.vec3("v"); }), "f.json: /camera/v/2: must be a finite number, but is \"x\"");
  EXPECT_THAT(message_of([&] { object.vec3("w"); }), EndsWith("must be an array of three numbers, but is [1,2]"));
  EXPECT_THAT(message_of([&] { object.integer("i", 1, 9); }), EndsWith("must be an integer from 1 to 9, but is 1.5"));
  EXPECT_THAT(message_of([&] { object.number("inf", Range::any()); }), EndsWith("but is not finite"));
  EXPECT_THAT(message_of([&] { object.boolean_or("n", true); }), EndsWith("must be true or false, but is -3"));
  EXPECT_THAT(message_of([&] { object.object("n"); }), EndsWith("/camera/n: must be an object {...}, but is -3"));
  EXPECT_THAT(message_of([&] { object.objects("n"); }), HasSubstr("must be an array [...] of objects"));
  EXPECT_THAT(message_of([&] { object.text("a/b"); }), StartsWith("f.json: /camera/a~1b: "));
}

TEST(JsonObject, UnknownChoiceListsTheValidOnes) {
  const json value = {{"type", "perspektive"}};
  JsonObject object = view(value);
  EXPECT_EQ(message_of([&] {
              object.choice("type", {"perspective", "orthographic"});
            }),
            "f.json: /camera/type: unknown choice \"perspektive\"; did you mean \"perspective\"? valid choices: "
            "perspective, orthographic");
}

TEST(Choices, NearestIsWithinTwoEditsAndIgnoresCase) {
  EXPECT_EQ(nearest_choice("SKIN", {"apple", "skin1", "skin2"}), "skin1");
  EXPECT_EQ(nearest_choice("kitten", {"sitting"}), "");  // the textbook pair, 3 edits apart
  EXPECT_EQ(nearest_choice("kittin", {"sittin"}), "sittin");
  EXPECT_EQ(nearest_choice("up", {"g"}), "");
}

TEST(ReadJsonFile, MissingFileAndFolderAreNamed) {
  TempFolder folder;
  EXPECT_EQ(message_of([&] { read_json_file(folder.file("no.json")); }),
            folder.file("no.json") + ": the file does not exist");
  EXPECT_THAT(message_of([&] { read_json_file(folder.file("")); }), HasSubstr("is a folder"));
}

TEST(ReadJsonFile, MalformedTextGivesLineAndColumn) {
  TempFolder folder;
  const std::string path = folder.write("bad.json", "{\n  \"a\": 1,\n  \"b\" 2\n}\n");
  EXPECT_THAT(message_of([&] { read_json_file(path); }), StartsWith(path + ": line 3:7: is not valid JSON: syntax"));
}

TEST(ReadJsonFile, TruncatedTextIsAnErrorAtItsEnd) {
  TempFolder folder;
  const std::string path = folder.write("cut.json", "{\n\"a\": [1,");
  EXPECT_THAT(message_of([&] { read_json_file(path); }), HasSubstr(": line 2:9: is not valid JSON"));
}

TEST(ReadJsonFile, NonFiniteLiteralsAreExplainedWhereTheyStand) {
  TempFolder folder;
  for (const char* literal : {"NaN", "Infinity", "-Infinity", "nan", "inf"}) {
    const std::string path = folder.write("n.json", std::string("{\n  \"eta\": ") + literal + "\n}\n");
    EXPECT_EQ(message_of([&] { read_json_file(path); }),
              path + ": line 2:10: NaN and Infinity are not JSON numbers; write a finite number")
        << literal;
  }
}

TEST(ReadJsonFile, NumberTooLargeForADoubleIsAnError) {
  TempFolder folder;
  const std::string path = folder.write("big.json", "{\"a\": 1e999}");
  EXPECT_THAT(message_of([&] { read_json_file(path); }), AllOf(StartsWith(path), HasSubstr("1e999")));
}

TEST(ReadJsonFile, RepeatedKeyIsAnError) {
  TempFolder folder;
  const std::string path = folder.write("two.json", R"({"a": {"eta": 1}, "b": {"eta": 1, "g": 0, "eta": 2}})");
  EXPECT_THAT(message_of([&] { read_json_file(path); }), HasSubstr("the key \"eta\" stands twice"));
  EXPECT_NO_THROW(read_json_file(folder.write("one.json", R"({"a": {"eta": 1}, "b": [{"eta": 1}, {"eta": 2}]})")));
}

TEST(WriteTextAtomically, ReplacesTheFileAndLeavesNothingBeside) {
  TempFolder folder;
  const std::string path = folder.write("out.json", "old and longer");
  write_text_atomically(path, "new");
  std::ifstream in(path);
  std::string text;
  std::getline(in, text);
  EXPECT_EQ(text, "new");
  EXPECT_EQ(folder.file_count(), 1u);
}

TEST(WriteTextAtomically, MissingFolderIsAnError) {
  TempFolder folder;
  const std::string path = folder.file("absent/out.json");
  EXPECT_THAT(message_of([&] { write_text_atomically(path, "x"); }),
              AllOf(StartsWith(path + ": cannot be written: the folder"), HasSubstr("does not exist")));
  EXPECT_THAT(message_of([&] { write_text_atomically(folder.file(""), "x"); }), HasSubstr("names a folder"));
}

}  // namespace
}  // namespace opaline
