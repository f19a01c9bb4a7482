// What a section of the report is made of: paragraphs, tables, figures. A section writes these once; html.h and
// markdown.h turn them into the two kinds of file.
#pragma once

#include <string>
#include <variant>
#include <vector>

namespace opaline {

/// How a cell is to be read; shown by colour and, in HTML, by a sign as well, never by colour alone.
enum class Tone { plain, good, bad, muted };

/// One cell of a table. All text is plain: escaping is the writer's.
struct TableCell {
  std::string text;
  Tone tone = Tone::plain;
  bool number = false;  ///< set flush right
  bool code = false;    ///< a command or a name, in fixed width
  std::string id;       ///< anchor that others link to, or empty
  std::string link;     ///< anchor this cell leads to, or empty

  TableCell() = default;
  TableCell(std::string words, Tone t = Tone::plain)
      : text(std::move(words)), tone(t) {}       // NOLINT: a table reads as its text
  TableCell(const char* words) : text(words) {}  // NOLINT
};

TableCell number_cell(std::string text);
TableCell code_cell(std::string text);
/// What stands where a value is missing: the reason, muted. A reason is never empty.
TableCell reason_cell(std::string reason);

struct Table {
  std::string caption;
  std::vector<std::string> header;
  std::vector<std::vector<TableCell>> rows;  ///< each as long as the header; the first cell names the row
  bool folded = false;                       ///< behind a disclosure widget, for tables few will read
};

struct Paragraph {
  std::string text;
  Tone tone = Tone::plain;
};

/// A heading below the section's own.
struct Heading {
  std::string text, id;
};

struct List {
  std::vector<std::string> items;
};

/// What only HTML can show, with the sentence that stands for it in Markdown. `html` is trusted: whoever builds it
/// has escaped every text in it.
struct HtmlFigure {
  std::string html, markdown;
};

using Block = std::variant<Paragraph, Heading, List, Table, HtmlFigure>;
using Blocks = std::vector<Block>;

/// One chapter, ready to be written.
struct Chapter {
  std::string id, title;
  Blocks blocks;
};

}  // namespace opaline
