// A child process's progress, in shared memory, so that it survives the child's death.
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

  /// Allocates it in shared memory. @throws std::runtime_error
  static Progress* make();

  std::atomic<std::uint64_t> input;   ///< number of the present input
  std::atomic<std::uint64_t> starts;  ///< number of inputs begun; changes with each of them
  std::atomic<bool> stop;             ///< set by the parent: no further inputs
  std::uint64_t refused, accepted;
  bool repeating;                           ///< earlier inputs are being run again
  std::uint64_t slowest_ns, slowest_input;  ///< by processor time
  bool finished;                            ///< reached the end of its block, or a finding
  bool has_finding;
  FindingKind kind;
  std::array<char, kText> text;
  std::array<void*, kFrames> frames;  ///< backtrace of a crash
  int frame_count;

  void clear();
  void note(FindingKind finding, const std::string& what);
};

}  // namespace skybody::fuzz
