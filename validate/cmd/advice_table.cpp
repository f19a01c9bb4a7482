#include "validate/cmd/advice_table.h"

#include "validate/pareto.h"

#include <fmt/format.h>

namespace opaline {

std::string front_table(const std::vector<Record>& records) {
  std::map<std::string, std::vector<Record>> groups;
  for (const Record& r : records) groups[r.scene + ", " + r.material].push_back(r);
  std::string text = "\nworth having (first picture, relative RMSE):\n";
  for (const auto& [group, members] : groups) {
    text += group + "\n";
    for (const CostPoint& point : pareto_front(cost_points(members, "relative_rmse"), 0.01)) {
      const Record& r = members[point.record];
      std::string settings;
      for (const auto& [key, value] : r.settings) settings += fmt::format(" {}={}", key, value);
      text += fmt::format("  {:>10.2f} ms  {:>9.3g}  {} {}{}\n", 1e3 * point.seconds, point.error, r.technique,
                          r.backend, settings);
    }
  }
  return text;
}

}  // namespace opaline
