// Consecutive inputs that one child process runs.
#pragma once

#include <cstdint>
#include <filesystem>

#include "tests/fuzz/area.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/progress.h"

namespace skybody::fuzz {

/// Resource limits of a process for one input. The documented limits are 2 s and 500 MB for a
/// megabyte of input (docs); here twice as much is allowed, for machines under load.
struct Limits {
  double processor_seconds = 4.0;
  double wall_seconds = 60.0;       ///< for an input that waits forever
  std::uint64_t memory = 1u << 30;  ///< of the whole process [bytes]
};

struct Block {
  Area* area;
  const Inputs* inputs;
  std::uint64_t first, count;
  bool only_accepted = false;  ///< a refusal is a wrong answer
};

/// Runs the block in this process and records the results in `progress`.
void run_block(const Block& block, const std::filesystem::path& folder, Progress& progress);

/// Sets this process's limits, and installs a handler that records the place of a crash.
void guard_process(const Limits& limits, Progress& progress);

}  // namespace skybody::fuzz
