#include "app/report/text_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <utility>

namespace skybody {
namespace {

constexpr const char* kGap = "  ";

/// Characters, not bytes: UTF-8 continuation bytes do not count.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

bool is_number(const std::string& text) {
  if (text == "nan" || text == "inf" || text == "-inf" || text == "-") return true;
  const std::size_t first = text.find_first_not_of("+-.");
  return first != std::string::npos && std::isdigit(static_cast<unsigned char>(text[first])) != 0;
}

/// Whether a column holds numbers, so that its heading is aligned right too.
std::vector<bool> numeric_columns(const std::vector<std::vector<std::string>>& rows,
                                  std::size_t n) {
  std::vector<bool> numeric(n, true);
  for (const std::vector<std::string>& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (!row[k].empty() && !is_number(row[k])) numeric[k] = false;
    }
  }
  return numeric;
}

std::string set_row(const std::vector<std::string>& row, const std::vector<std::size_t>& widths,
                    const std::vector<bool>& right) {
  std::string line;
  for (std::size_t k = 0; k < widths.size(); ++k) {
    const std::string cell = k < row.size() ? row[k] : "";
    const std::string space(widths[k] - width_of(cell), ' ');
    line += (k > 0 ? kGap : "") + (right[k] ? space + cell : cell + space);
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

}  // namespace

TextTable::TextTable(std::vector<std::string> heading) : heading_(std::move(heading)) {}

void TextTable::add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }

void TextTable::add_rule() { rows_.emplace_back(); }

std::string TextTable::to_string() const {
  std::vector<std::size_t> widths;
  for (std::size_t k = 0; k < heading_.size(); ++k) {
    std::size_t width = width_of(heading_[k]);
    for (const std::vector<std::string>& row : rows_) {
      if (k < row.size()) width = std::max(width, width_of(row[k]));
    }
    widths.push_back(width);
  }
  const std::vector<bool> right = numeric_columns(rows_, widths.size());
  std::vector<std::string> dashes;
  for (const std::size_t width : widths) dashes.emplace_back(width, '-');
  std::string text = set_row(heading_, widths, right) + set_row(dashes, widths, right);
  for (const std::vector<std::string>& row : rows_) {
    text += set_row(row.empty() ? dashes : row, widths, right);
  }
  return text;
}

std::string fixed(double value, int decimals) {
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

std::string short_number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

}  // namespace skybody
