#include "render/techniques/settings.h"

#include "tests/render/scene_fixture.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

using testing::HasSubstr;

std::vector<SettingSpec> specs() {
  return {{"quality", "0.2", "how good", {}, 0.001, 100}, {"mode", "fast", "how fast", {"fast", "slow"}}};
}

std::string error(const std::map<std::string, std::string>& given) {
  return test::message_of([&] { Settings(specs(), given); });
}

TEST(Settings, DefaultsAndGivenValues) {
  const Settings defaults(specs(), {});
  EXPECT_EQ(defaults.number("quality"), 0.2);
  EXPECT_EQ(defaults.word("mode"), "fast");
  const Settings given(specs(), {{"quality", "1.5e1"}, {"mode", "slow"}});
  EXPECT_EQ(given.number("quality"), 15);
  EXPECT_EQ(given.word("mode"), "slow");
  EXPECT_EQ(given.values(), (std::map<std::string, std::string>{{"quality", "1.5e1"}, {"mode", "slow"}}));
}

TEST(Settings, TextIsTakenAsItIs) {
  const std::vector<SettingSpec> file = {{"file", "", "where", {}, 0, 0, false, true}};
  EXPECT_EQ(Settings(file, {}).word("file"), "");
  EXPECT_EQ(Settings(file, {{"file", "a b=c.bin"}}).word("file"), "a b=c.bin");
}

TEST(Settings, TheEndsOfARangeAreValid) {
  EXPECT_EQ(Settings(specs(), {{"quality", "0.001"}}).number("quality"), 0.001);
  EXPECT_EQ(Settings(specs(), {{"quality", "100"}}).number("quality"), 100);
}

TEST(Settings, AnUnknownKeyIsNamedWithTheValidOnes) {
  EXPECT_EQ(error({{"qualty", "1"}}), "--set qualty: unknown setting; valid: quality, mode");
}

TEST(Settings, AWordThatIsNoChoiceIsNamedWithTheChoices) {
  EXPECT_EQ(error({{"mode", "medium"}}), "--set mode: 'medium' is not one of fast, slow");
}

TEST(Settings, WhatIsNoNumberInTheRangeIsAnError) {
  for (const char* text : {"", "x", "1x", " 1", "0", "100.1", "-1", "nan", "inf", "1e999", "0x1"}) {
    const std::string message = error({{"quality", text}});
    EXPECT_THAT(message, HasSubstr("--set quality: '" + std::string(text) + "'"));
    EXPECT_THAT(message, HasSubstr("from 0.001 to 100"));
  }
}

TEST(SettingsDeathTest, AskingForAnUndeclaredKeyIsABug) {
  EXPECT_DEATH(Settings(specs(), {}).word("nothing"), "internal check failed");
}

}  // namespace
}  // namespace opaline
