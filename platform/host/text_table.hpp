// One table, three prints: aligned plain text for a terminal, TSV for scripts, Markdown for a report. The cells are the
// same in all three. Never ends a line in a blank.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace aluminate::host {

enum class Align { Left, Right };

struct TableColumn {
  std::string header;
  Align align = Align::Left;
};

class TextTable {
 public:
  explicit TextTable(std::vector<TableColumn> columns);

  /// As many cells as columns.
  void add_row(std::vector<std::string> cells);
  /// A line of dashes in plain text; nothing elsewhere.
  void add_rule();

  std::size_t row_count() const;

  std::string text() const;      // two blanks between columns; width counts UTF-8 characters
  std::string tsv() const;       // header line first; tab and line breaks in a cell become blanks
  std::string markdown() const;  // '|' is escaped

 private:
  struct Row {
    bool is_rule = false;
    std::vector<std::string> cells;
  };
  std::vector<TableColumn> columns_;
  std::vector<Row> rows_;
};

}  // namespace aluminate::host
