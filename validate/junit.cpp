#include "validate/junit.h"

#include <fmt/format.h>

namespace opaline {
namespace {

/// XML 1.0 has no place for most control characters, not even escaped.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else if (c == '\n' || c == '\t')
      result += ' ';
    else
      result += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  }
  return result;
}

/// Test cases of one suite, counted as they are added.
class TestSuite {
 public:
  explicit TestSuite(std::string name) : name_(std::move(name)) {}

  /// kind: "failure", "error", "skipped", or null for a case that passed.
  void add(const std::string& name, double seconds, const char* kind, const std::string& message) {
    ++tests_;
    failures_ += kind && std::string(kind) == "failure";
    errors_ += kind && std::string(kind) == "error";
    skipped_ += kind && std::string(kind) == "skipped";
    cases_ += fmt::format("    <testcase classname=\"{}\" name=\"{}\" time=\"{:.6f}\"", escaped(name_), escaped(name),
                          seconds);
    cases_ += kind ? fmt::format(">\n      <{} message=\"{}\"/>\n    </testcase>\n", kind, escaped(message)) : "/>\n";
  }
  std::string xml() const {
    return fmt::format(
        "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\">\n{}  </testsuite>\n",
        escaped(name_), tests_, failures_, errors_, skipped_, cases_);
  }

 private:
  std::string name_, cases_;
  int tests_ = 0, failures_ = 0, errors_ = 0, skipped_ = 0;
};

}  // namespace

std::string junit_xml(const std::string& suite, const std::vector<GateResult>& gates,
                      const std::vector<Record>& records) {
  TestSuite of_gates("opaline." + suite + ".gates"), of_cells("opaline." + suite + ".cells");
  for (const GateResult& gate : gates) {
    const bool passed = gate.outcome == GateResult::Outcome::passed;
    const char* kind = passed ? nullptr : gate.outcome == GateResult::Outcome::failed ? "failure" : "skipped";
    of_gates.add(gate.name, 0, kind, gate.message + (gate.where.empty() ? "" : ": " + gate.where));
  }
  for (const Record& r : records) {
    const char* kind = r.status == CellStatus::done ? nullptr : r.status == CellStatus::failed ? "error" : "skipped";
    of_cells.add(r.name(), r.seconds.prepare.median + r.seconds.render.median, kind, r.reason);
  }
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n" + of_gates.xml() + of_cells.xml() +
         "</testsuites>\n";
}

}  // namespace opaline
