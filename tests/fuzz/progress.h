// What a child process tells its parent, in a page that both see: it is still there when the child
// is not.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "tests/fuzz/finding.h"

namespace skybody::fuzz {

struct Progress {
  static constexpr std::size_t kText = 1000;
  static constexpr std::size_t kFrames = 24;

  /// Made in shared memory. @throws std::runtime_error
  static Progress* make();

  std::atomic<std::uint64_t> input;   ///< the present one
  std::atomic<std::uint64_t> starts;  ///< inputs begun: changes whenever one is
  std::atomic<bool> stop;             ///< from the parent: no further inputs
  std::uint64_t refused, accepted;
  bool repeating;                           ///< inputs that were run before are run again
  std::uint64_t slowest_ns, slowest_input;  ///< by processor time
  bool finished;                            ///< came to the end of its block, or to a finding
  bool has_finding;
  FindingKind kind;
  std::array<char, kText> text;
  std::array<void*, kFrames> frames;  ///< where it crashed
  int frame_count;

  void clear();
  void note(FindingKind finding, const std::string& what);
};

}  // namespace skybody::fuzz
