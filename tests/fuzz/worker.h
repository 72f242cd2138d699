// A child process that runs a block of inputs, monitored by its parent.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "tests/fuzz/block.h"

namespace skybody::fuzz {

/// A finding and the number of its input.
struct Found {
  std::uint64_t input;
  FindingKind kind;
  std::string text;
};

/// Result of a block.
struct BlockEnd {
  std::uint64_t next;  ///< the first input that was not run
  std::uint64_t refused, accepted;
  std::uint64_t slowest_ns, slowest_input;
  double seconds;
  std::optional<Found> found;
};

class Worker {
 public:
  /// @param folder  for the worker's files; no other process uses it
  Worker(std::filesystem::path folder, const Limits& limits, bool quiet);

  bool busy() const { return child_ > 0; }
  const Block& block() const { return block_; }
  void start(const Block& block);
  /// Requests an end after the present input.
  void stop() { progress_->stop = true; }
  /// @returns the result once the block has ended; kills a child that takes too long
  std::optional<BlockEnd> poll();

 private:
  using Clock = std::chrono::steady_clock;

  [[noreturn]] void run_child();
  bool takes_too_long();
  double processor_seconds() const;
  BlockEnd end(std::optional<Found> found);
  Found crash(int status) const;

  std::filesystem::path folder_;
  Limits limits_;
  bool quiet_;
  Progress* progress_;
  Block block_{};
  pid_t child_ = 0;
  Clock::time_point began_;
  std::uint64_t starts_seen_ = 0;  ///< of the monitored input
  Clock::time_point input_began_;
  double input_processor_ = 0.0;
};

}  // namespace skybody::fuzz
