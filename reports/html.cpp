#include "reports/html.h"

#include <fmt/format.h>

namespace opaline {
namespace {

using nlohmann::ordered_json;

/// The same text as valid UTF-8. The JSON writer knows how to replace what is not.
std::string valid_utf8(const std::string& text) {
  const std::string quoted = ordered_json(text).dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  return ordered_json::parse(quoted).get<std::string>();
}

std::string attribute(const char* name, const std::string& value) {
  return value.empty() ? "" : fmt::format(" {}=\"{}\"", name, html_escaped(value));
}

/// Tables with more rows have columns of one width: a browser lays those out several times as fast.
constexpr std::size_t long_table = 300;

/// Longer ones may wrap.
constexpr std::size_t longest_number = 18;

/// Escaped text with `words` in backquotes as code.
std::string with_code(const std::string& text) {
  std::string out;
  bool inside = false;
  for (const char c : html_escaped(text)) {
    if (c != '`') {
      out += c;
      continue;
    }
    out += inside ? "</code>" : "<code>";
    inside = !inside;
  }
  return inside ? out + "</code>" : out;
}

/// The sign before a toned text, for those who don't see the colour.
const char* sign(Tone tone) { return tone == Tone::good ? "✓ " : tone == Tone::bad ? "✗ " : ""; }

std::string classes(const TableCell& cell) {
  std::string names;
  if (cell.number) names += cell.text.size() > longest_number ? "n wide " : "n ";
  if (cell.tone == Tone::good) names += "good ";
  if (cell.tone == Tone::bad) names += "bad ";
  if (cell.tone == Tone::muted) names += "muted ";
  if (!names.empty()) names.pop_back();
  return names;
}

std::string cell_html(const TableCell& cell, bool names_row) {
  std::string text = sign(cell.tone) + html_escaped(cell.text);
  if (cell.code) text = "<code>" + text + "</code>";
  if (!cell.link.empty()) text = fmt::format("<a href=\"#{}\">{}</a>", html_escaped(cell.link), text);
  const std::string attributes = attribute("class", classes(cell)) + attribute("id", cell.id);
  return names_row ? fmt::format("<th scope=\"row\"{}>{}</th>", attributes, text)
                   : fmt::format("<td{}>{}</td>", attributes, text);
}

std::string row_html(const std::vector<TableCell>& row) {
  std::string line = "<tr>";
  for (std::size_t i = 0; i < row.size(); ++i) line += cell_html(row[i], i == 0);
  return line + "</tr>\n";
}

/// A head over a column of numbers is flush right like them.
std::string header_html(const Table& table) {
  std::string line = "<thead><tr>";
  for (std::size_t i = 0; i < table.header.size(); ++i) {
    const bool number = !table.rows.empty() && table.rows.front().at(i).number;
    line += fmt::format("<th scope=\"col\"{}>{}</th>", number ? " class=\"n\"" : "", html_escaped(table.header[i]));
  }
  return line + "</tr></thead>\n";
}

std::string html(const Paragraph& p) {
  const char* style = p.tone == Tone::bad     ? " class=\"bad\""
                      : p.tone == Tone::good  ? " class=\"good\""
                      : p.tone == Tone::muted ? " class=\"muted\""
                                              : "";
  return fmt::format("<p{}>{}{}</p>\n", style, sign(p.tone), with_code(p.text));
}

std::string html(const Heading& h) {
  return fmt::format("<h3{}>{}</h3>\n", attribute("id", h.id), html_escaped(h.text));
}

std::string html(const List& list) {
  std::string text = "<ul>\n";
  for (const std::string& item : list.items) text += "<li>" + html_escaped(item) + "</li>\n";
  return text + "</ul>\n";
}

std::string html(const HtmlFigure& figure) { return figure.html; }

}  // namespace

TableCell number_cell(std::string text) {
  TableCell cell(std::move(text));
  cell.number = true;
  return cell;
}

TableCell code_cell(std::string text) {
  TableCell cell(std::move(text));
  cell.code = true;
  return cell;
}

TableCell reason_cell(std::string reason) {
  return TableCell(reason.empty() ? "no reason was recorded" : std::move(reason), Tone::muted);
}

std::string html_escaped(const std::string& text) {
  std::string out;
  for (const char c : valid_utf8(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      case '\t':
      case '\n':
        out += c;
        break;
      default:
        static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? out += "\xEF\xBF\xBD" : out += c;
    }
  }
  return out;
}

std::string script_json(const ordered_json& json) {
  std::string out;
  for (const char c : json.dump(-1, ' ', false, ordered_json::error_handler_t::replace))
    c == '<' ? out += "\\u003c" : out += c;
  return out;
}

// The wrapper scrolls sideways on a narrow screen; being focusable, it does so by keyboard too.
std::string html(const Table& table) {
  std::string body = fmt::format("<table{}><caption><span>{}</span></caption>\n",
                                 table.rows.size() > long_table ? " class=\"long\"" : "", html_escaped(table.caption)) +
                     header_html(table) + "<tbody>\n";
  for (const auto& row : table.rows) body += row_html(row);
  body =
      fmt::format("<div class=\"scroll\" role=\"region\" tabindex=\"0\" aria-label=\"{}\">{}</tbody></table></div>\n",
                  html_escaped(table.caption), body);
  if (!table.folded) return body;
  return fmt::format("<details><summary>{} ({} rows)</summary>\n{}</details>\n", html_escaped(table.caption),
                     table.rows.size(), body);
}

std::string html(const Block& block) {
  return std::visit([](const auto& b) { return html(b); }, block);
}

std::string html(const Chapter& chapter) {
  std::string text = fmt::format("<section id=\"{0}\" aria-labelledby=\"{0}-title\">\n<h2 id=\"{0}-title\">{1}</h2>\n",
                                 html_escaped(chapter.id), html_escaped(chapter.title));
  for (const Block& block : chapter.blocks) text += html(block);
  return text + "</section>\n";
}

}  // namespace opaline
