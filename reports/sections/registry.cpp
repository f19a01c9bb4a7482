#include "reports/sections/section.h"

#include <stdexcept>

namespace opaline {

#define OPALINE_ROW(name) Section name##_section();
#include "section_registry.inc"
#undef OPALINE_ROW

const std::vector<Section>& sections() {
  static const std::vector<Section> all = {
#define OPALINE_ROW(name) name##_section(),
#include "section_registry.inc"
#undef OPALINE_ROW
  };
  return all;
}

std::vector<Chapter> write_sections(const ReportData& data) {
  std::vector<Chapter> chapters;
  for (const Section& section : sections()) {
    chapters.push_back({section.id, section.title, section.write(data)});
    if (chapters.back().blocks.empty()) throw std::logic_error("section " + section.id + " wrote nothing");
  }
  return chapters;
}

}  // namespace opaline
