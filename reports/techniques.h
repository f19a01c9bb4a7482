// The techniques a report speaks of: those that are registered and those that only appear in records.
#pragma once

#include "validate/record.h"

#include <string>
#include <vector>

namespace opaline {

struct Technique;

/// Registered techniques first, in their order, then others (external ones) in the order of their first record.
std::vector<std::string> shown_techniques(const std::vector<Record>& records);

/// "cpu", "gpu", and what else records have: "external".
std::vector<std::string> shown_backends(const std::vector<Record>& records);

/// The registered technique of that name, or null.
const Technique* registered_technique(const std::string& name);

/// Why there may be no record of it: it has no such backend, is built in or external, or wasn't part of the run.
std::string absence_reason(const std::string& technique, const std::string& backend);

/// A setting's value in a record: what the sweep set, else the technique's default, else empty.
std::string setting_of(const Record& record, const std::string& key);

/// Does the registered technique have that setting with that value among the valid ones?
bool technique_takes(const std::string& technique, const std::string& key, const std::string& value);

}  // namespace opaline
