// Blocks as HTML, and the two ways of escaping.
#pragma once

#include "reports/document.h"

#include <nlohmann/json.hpp>

namespace opaline {

/// Text for an element or a quoted attribute: & < > " ' become character references; control characters that HTML
/// forbids and bytes that are no UTF-8 become U+FFFD.
std::string html_escaped(const std::string& text);

/// JSON for <script type="application/json">: no "<", so that no text can end the script.
std::string script_json(const nlohmann::ordered_json& json);

std::string html(const Table& table);
std::string html(const Block& block);
std::string html(const Chapter& chapter);

}  // namespace opaline
