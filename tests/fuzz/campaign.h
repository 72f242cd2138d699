// The campaign: runs all areas at once in several processes and collects the results.
#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <memory>
#include <vector>

#include "tests/fuzz/options.h"
#include "tests/fuzz/tally.h"
#include "tests/fuzz/worker.h"

namespace skybody::fuzz {

class Campaign {
 public:
  /// Makes the areas. @param folder  for the files of areas and workers
  Campaign(const Options& options, std::filesystem::path folder);

  /// Runs everything, prints findings to stderr and saves their inputs.
  std::vector<Tally> run();
  /// Runs everything in this process, for a debugger; nothing is caught.
  void run_here();

 private:
  using Clock = std::chrono::steady_clock;

  /// Remaining inputs of an area.
  struct Queue {
    std::unique_ptr<Inputs> inputs;
    std::uint64_t next = 0, end = 0;
    bool only_accepted = false;
  };
  struct Front {
    const AreaRow* row;
    std::unique_ptr<Area> area;
    std::vector<Queue> queues;  ///< in order of execution
    Tally tally;
    int workers = 0;
    std::uint64_t told = 0;  ///< findings printed so far
  };
  /// A worker, and its part of a queue.
  struct Job {
    Worker worker;
    Front* front = nullptr;
    const Queue* queue = nullptr;
    std::uint64_t end = 0;
  };

  void add_queues(Front& front) const;
  static Queue* queue_of(Front& front);
  Front* next_front();
  std::uint64_t block_size(const Front& front) const;
  bool start(Job& job);
  static void run_from(Job& job, std::uint64_t first);
  void take(Job& job, const BlockEnd& end);
  void tell(Front& front, const Inputs& inputs, const Found& found) const;
  std::uint64_t inputs() const;
  bool is_over() const;

  const Options& options_;
  std::filesystem::path folder_;
  std::deque<Front> fronts_;  // deque: jobs hold pointers to the elements
  Clock::time_point deadline_;
};

}  // namespace skybody::fuzz
