#include "model/simd.h"

#include <hwy/highway.h>
#include <hwy/targets.h>

namespace opaline {
namespace {

std::vector<std::int64_t> usable_targets() {
  hwy::SetSupportedTargetsForTest(0);
  std::vector<std::int64_t> targets;
  const std::int64_t supported = hwy::SupportedTargets() & HWY_TARGETS;
  for (std::int64_t bit = 1; bit > 0; bit <<= 1)  // lower bits are better targets
    if (supported & bit) targets.push_back(bit);
  return targets;
}

}  // namespace

std::string simd_target() {
  const std::int64_t supported = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(supported & -supported);
}

std::vector<std::string> simd_targets() {
  std::vector<std::string> names;
  for (const std::int64_t target : usable_targets()) names.emplace_back(hwy::TargetName(target));
  return names;
}

bool limit_simd_target(const std::string& name) {
  const std::vector<std::int64_t> targets = usable_targets();
  std::int64_t allowed = 0;
  bool found = name.empty();
  for (const std::int64_t target : targets) {
    found = found || hwy::TargetName(target) == name;
    if (found) allowed |= target;
  }
  hwy::SetSupportedTargetsForTest(allowed);
  hwy::GetChosenTarget().Update(allowed ? allowed : hwy::SupportedTargets());
  return found;
}

}  // namespace opaline
