#include "model/profiles/profile.h"

#include <algorithm>

namespace opaline {

#define OPALINE_ROW(name) ProfileInfo name##_profile();
#include "profile_registry.inc"
#undef OPALINE_ROW

const std::vector<ProfileInfo>& profiles() {
  static const std::vector<ProfileInfo> rows = {
#define OPALINE_ROW(name) name##_profile(),
#include "profile_registry.inc"
#undef OPALINE_ROW
  };
  return rows;
}

const ProfileInfo* find_profile(const std::string& name) {
  const auto row = std::ranges::find(profiles(), name, &ProfileInfo::name);
  return row == profiles().end() ? nullptr : &*row;
}

std::vector<std::string> profile_names() {
  std::vector<std::string> names;
  for (const ProfileInfo& info : profiles()) names.push_back(info.name);
  return names;
}

std::vector<std::string> medium_profile_names() {
  std::vector<std::string> names;
  for (const ProfileInfo& info : profiles()) {
    if (info.needs_medium_alone()) names.push_back(info.name);
  }
  return names;
}

}  // namespace opaline
