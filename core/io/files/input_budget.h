// Limits of one scenario's input, with all includes, aliases and named files.
//
// Small files can expand to much data: aliases repeat values, includes repeat files, robots repeat
// models. All data read or copied for one scenario is counted here. These limits therefore bound
// work and memory. docs/scenarios.md has the table.
#pragma once

#include <cstddef>

namespace skybody {

class InputBudget {
 public:
  /// Values in all YAML of a scenario: each takes about 300 bytes in memory and is copied two or
  /// three times while includes are merged. The largest shipped scenario has 300.
  static constexpr long kMostValues = 200'000;
  /// Text of these values and keys, and the names of their files [bytes].
  static constexpr std::size_t kMostText = 32u << 20;
  /// Text of all files, URDF included [bytes].
  static constexpr std::size_t kMostFileText = 16u << 20;
  /// Uses of `include`.
  static constexpr int kMostIncludes = 100;
  /// Nested levels of maps and lists: functions on trees are recursive.
  static constexpr int kDeepest = 64;
  /// Overrides by --set: each traverses the tree.
  static constexpr int kMostOverrides = 1000;

  /// Counts values with `bytes` of text; false above the limits.
  [[nodiscard]] bool take_values(long values, std::size_t bytes) {
    values_ += values;
    text_ += bytes;
    return values_ <= kMostValues && text_ <= kMostText;
  }

  /// Counts a file that was read; false if the files together are too large.
  [[nodiscard]] bool take_file(std::size_t bytes) {
    file_text_ += bytes;
    return file_text_ <= kMostFileText;
  }

  /// Counts a use of `include`; false above the limit.
  [[nodiscard]] bool take_include() { return ++includes_ <= kMostIncludes; }

 private:
  long values_ = 0;
  std::size_t text_ = 0;
  std::size_t file_text_ = 0;
  int includes_ = 0;
};

}  // namespace skybody
