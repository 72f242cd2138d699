// A table for terminals: columns as wide as their widest cell.
#pragma once

#include <string>
#include <vector>

namespace skybody {

/// Collects rows and sets them. Cells that start with a digit, a sign or a dash lean right.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> heading);

  void add(std::vector<std::string> row);
  /// A rule across all columns.
  void add_rule();
  bool empty() const { return rows_.empty(); }

  /// All lines, each with its end.
  std::string to_string() const;

 private:
  std::vector<std::string> heading_;
  std::vector<std::vector<std::string>> rows_;  ///< an empty row is a rule
};

/// `value` with `decimals` digits behind the point.
std::string fixed(double value, int decimals);
/// `value` with six digits that count.
std::string short_number(double value);

}  // namespace skybody
