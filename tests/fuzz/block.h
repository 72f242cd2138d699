// Consecutive inputs that one child process runs.
#pragma once

#include <cstdint>
#include <filesystem>

#include "tests/fuzz/area.h"
#include "tests/fuzz/inputs.h"
#include "tests/fuzz/progress.h"

namespace skybody::fuzz {

/// What a process may use for one input. A megabyte is to take at most 2 s and 500 MB (docs); twice
/// that is allowed here, for machines that do other things.
struct Limits {
  double processor_seconds = 4.0;
  double wall_seconds = 60.0;       ///< waiting for something that never comes
  std::uint64_t memory = 1u << 30;  ///< of the whole process [bytes]
};

struct Block {
  Area* area;
  const Inputs* inputs;
  std::uint64_t first, count;
  bool only_accepted = false;  ///< a refusal is a wrong answer
};

/// Runs the block in this process and tells `progress`.
void run_block(const Block& block, const std::filesystem::path& folder, Progress& progress);

/// Sets this process's limits, and notes where it crashes if it does.
void guard_process(const Limits& limits, Progress& progress);

}  // namespace skybody::fuzz
