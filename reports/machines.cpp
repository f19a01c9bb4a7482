#include "reports/machines.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

namespace opaline {

std::vector<std::string> machine_lines(const std::vector<Record>& records) {
  using Machine = std::tuple<std::string, int, std::string, std::string>;
  struct Use {
    std::vector<std::string> gl;
    std::string first, last;
  };
  std::map<Machine, Use> machines;
  for (const Record& r : records) {
    const RecordMachine& m = r.machine;
    Use& use = machines[{m.cpu, m.cores, m.version, m.compiler}];
    if (!m.gl_renderer.empty() && std::find(use.gl.begin(), use.gl.end(), m.gl_renderer) == use.gl.end())
      use.gl.push_back(m.gl_renderer);
    if (use.first.empty() || m.time < use.first) use.first = m.time;
    use.last = std::max(use.last, m.time);
  }
  std::vector<std::string> lines;
  for (const auto& [machine, use] : machines) {
    const auto& [cpu, cores, version, compiler] = machine;
    lines.push_back(fmt::format("Machine: {}, {} cores; GL: {}; Opaline {}, {}; measured {} to {}.", cpu, cores,
                                use.gl.empty() ? "none used" : fmt::format("{}", fmt::join(use.gl, ", ")), version,
                                compiler, use.first, use.last));
  }
  return lines;
}

}  // namespace opaline
