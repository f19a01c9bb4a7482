#include "reports/techniques.h"

#include "render/input_error.h"
#include "render/techniques/technique.h"
#include "reports/analysis.h"

#include <algorithm>

namespace opaline {

std::vector<std::string> shown_techniques(const std::vector<Record>& records) {
  std::vector<std::string> names;
  for (const Technique& t : techniques()) names.push_back(t.name);
  for (const std::string& name : technique_names(records))
    if (registered_technique(name) == nullptr) names.push_back(name);
  return names;
}

std::vector<std::string> shown_backends(const std::vector<Record>& records) {
  std::vector<std::string> names = {"cpu", "gpu"};
  for (const Record& r : records)
    if (std::find(names.begin(), names.end(), r.backend) == names.end()) names.push_back(r.backend);
  return names;
}

const Technique* registered_technique(const std::string& name) {
  for (const Technique& t : techniques())
    if (t.name == name) return &t;
  return nullptr;
}

std::string absence_reason(const std::string& technique, const std::string& backend) {
  const Technique* t = registered_technique(technique);
  if (t == nullptr && backend != "external") return "an external command: it has no backends";
  if (t != nullptr && backend == "external") return "built in";
  if (t != nullptr && std::find(t->backends.begin(), t->backends.end(), backend) == t->backends.end())
    return "the technique has no " + backend + " backend";
  return "not part of this run";
}

std::string setting_of(const Record& record, const std::string& key) {
  if (const auto it = record.settings.find(key); it != record.settings.end()) return it->second;
  if (const Technique* t = registered_technique(record.technique))
    for (const SettingSpec& spec : t->settings)
      if (spec.key == key) return spec.fallback;
  return "";
}

bool technique_takes(const std::string& technique, const std::string& key, const std::string& value) {
  const Technique* t = registered_technique(technique);
  if (t == nullptr) return false;
  try {
    Settings(t->settings, {{key, value}});
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace opaline
