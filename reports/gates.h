// The verdict of the gates: gates.json, {"gates": [{"name", "outcome": "passed" | "failed" | "skipped",
// "value", "max" or "min", "where", "message"}]}.
#pragma once

#include "reports/document.h"

#include <nlohmann/json.hpp>

#include <optional>

namespace opaline {

/// One sentence, good or bad; muted when no gate was checked.
Paragraph gates_verdict(const std::optional<nlohmann::json>& gates);

/// Every gate, those that fell short first.
Table gates_table(const nlohmann::json& gates);

}  // namespace opaline
