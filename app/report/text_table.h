// A table for terminals: columns as wide as their widest cell.
#pragma once

#include <string>
#include <vector>

namespace skybody {

/// Collects and formats rows. Cells that start with a digit, a sign or a dash are aligned right.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> heading);

  void add(std::vector<std::string> row);
  /// A rule across all columns.
  void add_rule();
  bool empty() const { return rows_.empty(); }

  /// All lines, each with a line break.
  std::string to_string() const;

 private:
  std::vector<std::string> heading_;
  std::vector<std::vector<std::string>> rows_;  ///< an empty row stands for a rule
};

/// `value` with `decimals` digits after the decimal point.
std::string fixed(double value, int decimals);
/// `value` with six significant digits.
std::string short_number(double value);

}  // namespace skybody
