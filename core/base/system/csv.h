// Text of comma-separated tables: lines and cells.
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

namespace skybody::csv {

/// Without blanks at both ends.
inline std::string_view trimmed(std::string_view text) {
  const char* const blank = " \t\r";
  const std::size_t first = text.find_first_not_of(blank);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

/// Removes and returns the text before a separator; all of it if there is none.
inline std::string_view cut(std::string_view& rest, char separator) {
  const std::size_t end = std::min(rest.find(separator), rest.size());
  const std::string_view part = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return part;
}

/// The trimmed cells of a line.
inline std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells(
      static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1);
  for (std::string_view& cell : cells) cell = trimmed(cut(line, ','));
  return cells;
}

/// Calls `take(row, line)` for each row, with its line number from 1, until one returns false.
/// Empty lines, comments after `#` and a byte order mark, as written by spreadsheets, are skipped.
/// @returns whether all rows were taken
template <class Take>
bool each_row(std::string_view text, Take&& take) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  for (int line = 1; !text.empty(); ++line) {
    const std::string_view row = trimmed(cut(text, '\n'));
    if (row.empty() || row.front() == '#') continue;
    if (!take(row, line)) return false;
  }
  return true;
}

}  // namespace skybody::csv
