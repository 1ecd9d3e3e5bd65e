#include "platform/host/text_table.hpp"

#include <algorithm>
#include <utility>

#include "platform/host/error.hpp"

namespace aluminate::host {
namespace {

// Code points, not bytes: continuation bytes are 10xxxxxx.
std::size_t character_count(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

void append_aligned(std::string& line, const std::string& cell, std::size_t width, Align align) {
  const std::string padding(width - character_count(cell), ' ');
  line += align == Align::Right ? padding + cell : cell + padding;
}

void end_line(std::string& all, std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  all += line + '\n';
}

std::string one_line(std::string cell) {
  std::replace_if(cell.begin(), cell.end(), [](char c) { return c == '\t' || c == '\n' || c == '\r'; }, ' ');
  return cell;
}

std::string markdown_cell(const std::string& cell) {
  std::string text;
  for (char c : one_line(cell)) {
    if (c == '|') text += '\\';
    text += c;
  }
  return text;
}

}  // namespace

TextTable::TextTable(std::vector<TableColumn> columns) : columns_(std::move(columns)) {
  ALU_CHECK(!columns_.empty(), "a table needs a column");
}

void TextTable::add_row(std::vector<std::string> cells) {
  ALU_CHECK(cells.size() == columns_.size(), "{} cells for {} columns", cells.size(), columns_.size());
  rows_.push_back({false, std::move(cells)});
}

void TextTable::add_rule() { rows_.push_back({true, {}}); }

std::size_t TextTable::row_count() const {
  return static_cast<std::size_t>(std::count_if(rows_.begin(), rows_.end(), [](const Row& row) { return !row.is_rule; }));
}

std::string TextTable::text() const {
  std::vector<std::size_t> widths;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    std::size_t width = character_count(columns_[i].header);
    for (const Row& row : rows_) {
      if (!row.is_rule) width = std::max(width, character_count(row.cells[i]));
    }
    widths.push_back(width);
  }
  std::string all, line;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (i > 0) line += "  ";
    append_aligned(line, columns_[i].header, widths[i], columns_[i].align);
  }
  end_line(all, line);
  for (const Row& row : rows_) {
    line.clear();
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (i > 0) line += "  ";
      if (row.is_rule) {
        line += std::string(widths[i], '-');
      } else {
        append_aligned(line, row.cells[i], widths[i], columns_[i].align);
      }
    }
    end_line(all, line);
  }
  return all;
}

std::string TextTable::tsv() const {
  std::string all;
  for (std::size_t i = 0; i < columns_.size(); ++i) all += (i > 0 ? "\t" : "") + one_line(columns_[i].header);
  all += '\n';
  for (const Row& row : rows_) {
    if (row.is_rule) continue;
    for (std::size_t i = 0; i < row.cells.size(); ++i) all += (i > 0 ? "\t" : "") + one_line(row.cells[i]);
    all += '\n';
  }
  return all;
}

std::string TextTable::markdown() const {
  std::string all = "|", rule = "|";
  for (const TableColumn& column : columns_) {
    all += ' ' + markdown_cell(column.header) + " |";
    rule += column.align == Align::Right ? " ---: |" : " --- |";
  }
  all += '\n' + rule + '\n';
  for (const Row& row : rows_) {
    if (row.is_rule) continue;
    all += '|';
    for (const std::string& cell : row.cells) all += ' ' + markdown_cell(cell) + " |";
    all += '\n';
  }
  return all;
}

}  // namespace aluminate::host
