// A finding: an error in the program's answer to an input.
#pragma once

#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace skybody::fuzz {

enum class FindingKind { kCrash, kHang, kMemory, kLeak, kSilentChange, kWrongAnswer };
inline constexpr std::size_t kFindingKinds = 6;

/// Column titles of the table, in the order of the enumerators.
inline constexpr std::array<const char*, kFindingKinds> kFindingTitles = {
    "crashes", "hangs", "memory", "leaks", "silent changes", "wrong answers"};
/// Names for messages.
inline constexpr std::array<const char*, kFindingKinds> kFindingNames = {
    "crash", "hang", "memory", "leak", "silent change", "wrong answer"};

/// Thrown by an area whose check fails.
class Finding : public std::runtime_error {
 public:
  Finding(FindingKind kind, const std::string& what) : std::runtime_error(what), kind_(kind) {}
  FindingKind kind() const { return kind_; }

 private:
  FindingKind kind_;
};

[[noreturn]] inline void wrong_answer(const std::string& what) {
  throw Finding(FindingKind::kWrongAnswer, what);
}
[[noreturn]] inline void silent_change(const std::string& what) {
  throw Finding(FindingKind::kSilentChange, what);
}

}  // namespace skybody::fuzz
