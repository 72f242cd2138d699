// How much one scenario may hold, with everything that it includes, repeats and names.
//
// Small files can ask for much: aliases repeat values, includes repeat files, robots repeat models.
// Whatever is read or copied for one scenario is counted here, so that work and memory are bounded
// by these limits and not by what a file asks for. docs/scenarios.md has the table.
#pragma once

#include <cstddef>

namespace skybody {

class InputBudget {
 public:
  /// Values of all YAML of a scenario: each is about 300 bytes in memory and is copied two or three
  /// times while includes merge. The largest shipped scenario has 300.
  static constexpr long kMostValues = 200'000;
  /// Text of these values and keys, and the names of their files [bytes].
  static constexpr std::size_t kMostText = 32u << 20;
  /// Text of all files, URDF included [bytes].
  static constexpr std::size_t kMostFileText = 16u << 20;
  /// Uses of `include`.
  static constexpr int kMostIncludes = 100;
  /// Levels of maps and lists in each other: functions that walk a tree call themselves.
  static constexpr int kDeepest = 64;
  /// Overrides by --set: each walks the tree.
  static constexpr int kMostOverrides = 1000;

  /// Counts values with `bytes` of text; false once there are too many.
  [[nodiscard]] bool take_values(long values, std::size_t bytes) {
    values_ += values;
    text_ += bytes;
    return values_ <= kMostValues && text_ <= kMostText;
  }

  /// Counts a file that was read; false once all are too large together.
  [[nodiscard]] bool take_file(std::size_t bytes) {
    file_text_ += bytes;
    return file_text_ <= kMostFileText;
  }

  /// Counts a use of `include`; false once there are too many.
  [[nodiscard]] bool take_include() { return ++includes_ <= kMostIncludes; }

 private:
  long values_ = 0;
  std::size_t text_ = 0;
  std::size_t file_text_ = 0;
  int includes_ = 0;
};

}  // namespace skybody
