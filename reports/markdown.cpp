#include "reports/markdown.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace opaline {
namespace {

/// In backquotes only the backquote itself and, in a table, the bar matter.
std::string code(const std::string& text) {
  std::string out = "`";
  for (const char c : text) c == '`' ? out += '\'' : c == '|' ? out += "\\|" : c == '\n' ? out += ' ' : out += c;
  return out + "`";
}

std::string cell_text(const TableCell& cell) {
  const char* sign = cell.tone == Tone::bad ? "✗ " : cell.tone == Tone::good ? "✓ " : "";
  return sign + (cell.code ? code(cell.text) : markdown_escaped(cell.text));
}

std::string markdown(const Table& table) {
  std::string text = fmt::format("**{}**\n\n|", markdown_escaped(table.caption)), rule = "|";
  for (std::size_t i = 0; i < table.header.size(); ++i) {
    text += " " + markdown_escaped(table.header[i]) + " |";
    rule += !table.rows.empty() && table.rows.front().at(i).number ? " ---: |" : " --- |";
  }
  text += "\n" + rule + "\n";
  for (const auto& row : table.rows) {
    text += "|";
    for (const TableCell& cell : row) text += " " + cell_text(cell) + " |";
    text += "\n";
  }
  return table.folded
             ? fmt::format("<details><summary>{} rows</summary>\n\n{}\n</details>\n\n", table.rows.size(), text)
             : text + "\n";
}

std::string markdown(const Paragraph& p) {
  const char* sign = p.tone == Tone::bad ? "✗ " : p.tone == Tone::good ? "✓ " : "";
  return sign + markdown_escaped(p.text) + "\n\n";
}
std::string markdown(const Heading& h) { return "### " + markdown_escaped(h.text) + "\n\n"; }
std::string markdown(const List& list) {
  std::string text;
  for (const std::string& item : list.items) text += "- " + markdown_escaped(item) + "\n";
  return text + "\n";
}
std::string markdown(const HtmlFigure& figure) {
  return figure.markdown.empty() ? "" : markdown_escaped(figure.markdown) + "\n\n";
}

}  // namespace

std::string markdown_escaped(const std::string& text) {
  constexpr std::string_view special = "\\`*_{}[]<>#|~!$";
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string_view::npos) out += '\\';
    out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out;
}

std::string markdown(const Block& block) {
  return std::visit([](const auto& b) { return markdown(b); }, block);
}

std::string markdown(const Chapter& chapter) {
  std::string text = "## " + markdown_escaped(chapter.title) + "\n\n";
  for (const Block& block : chapter.blocks) text += markdown(block);
  return text;
}

}  // namespace opaline
