#include "model/simd.h"

#include <gtest/gtest.h>

#include <set>

namespace opaline {
namespace {

/// Lifts the limit at the end of a test.
struct NoLimitAfterwards {
  ~NoLimitAfterwards() { limit_simd_target(""); }
};

TEST(Simd, TheBestTargetIsInForceUntilLimited) {
  const NoLimitAfterwards guard;
  const std::vector<std::string> targets = simd_targets();
  ASSERT_FALSE(targets.empty());
  ASSERT_TRUE(limit_simd_target(""));
  EXPECT_EQ(simd_target(), targets.front());
}

TEST(Simd, EveryListedTargetCanBeForced) {
  const NoLimitAfterwards guard;
  const std::vector<std::string> targets = simd_targets();
  for (const std::string& name : targets) {
    EXPECT_TRUE(limit_simd_target(name)) << name;
    EXPECT_EQ(simd_target(), name);
    EXPECT_EQ(simd_targets(), targets) << "a limit must not shorten the list";
    limit_simd_target(name);
  }
  EXPECT_EQ(std::set<std::string>(targets.begin(), targets.end()).size(), targets.size());
}

TEST(Simd, ATargetTheProcessorLacksIsRefusedAndLimitsNothing) {
  const NoLimitAfterwards guard;
  EXPECT_FALSE(limit_simd_target("AVX99"));
  EXPECT_EQ(simd_target(), simd_targets().front()) << "nothing is limited then";
}

}  // namespace
}  // namespace opaline
