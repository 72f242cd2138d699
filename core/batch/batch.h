// The result of recv(): rows of finished transitions, one per environment, in memory that learners
// read without a copy.
#pragma once

#include <cstdint>
#include <new>
#include <vector>

#include "core/base/system/error.h"

namespace skybody {

/// The caller still holds a buffer that is to be reused. Thrown with debug_buffers only.
class BufferInUse : public Error {
 public:
  using Error::Error;
};

/// Cache-line aligned, so that rows of neighbouring workers do not share lines at the block's ends
/// and learners may use aligned loads.
template <class T>
struct LineAllocator {
  using value_type = T;
  LineAllocator() = default;
  template <class U>
  LineAllocator(const LineAllocator<U>&) {}
  T* allocate(std::size_t n) {
    return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{64}));
  }
  void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
  bool operator==(const LineAllocator&) const { return true; }
};
template <class T>
using Column = std::vector<T, LineAllocator<T>>;

/// Widths of the rows.
struct RowWidths {
  int observation = 0;
  int agents = 0;
  int info = 0;
  int privileged = 0;
  std::vector<int> images;  ///< bytes of each image
};

/// Rows of up to `row_capacity` transitions. Row i of a column of width w begins at i * w.
struct Batch {
  Batch(int row_capacity, const RowWidths& row_widths, bool with_final);

  /// Copies `count` rows of another batch with the same widths, from its row `first` on, to row
  /// `at`. Final rows are copied only where an episode ended.
  void take(const Batch& from, int first, int count, int at);
  /// Copies a row's observation, info, privileged row and images to its final columns.
  void keep_final(int row);
  /// Fills all floats with NaN, to expose reads of stale memory.
  void poison();

  RowWidths width;
  int rows = 0;                       ///< number of filled rows
  Column<float> observation;          ///< after the transition; under kSameStep, after the reset
  Column<float> reward;               ///< width 1; with a team, the team's reward
  Column<float> agent_reward;         ///< width `width.agents`
  Column<float> info;                 ///< of the task, then of other plugins; width `width.info`
  Column<std::uint64_t> status;       ///< EpisodeStatus bits of the transition
  Column<std::uint8_t> terminated;    ///< 1: the task ended the episode
  Column<std::uint8_t> truncated;     ///< 1: ended by horizon, task, or a fault
  Column<std::uint8_t> fault;         ///< 1: bad action, state or outcome; not to be bootstrapped
  Column<std::uint8_t> was_reset;     ///< 1: the transition was a reset: no reward, action ignored
  Column<std::int32_t> env_id;        ///< id of the environment, 0 ... N_E - 1
  Column<std::int32_t> episode_step;  ///< actions taken in the row's episode
  Column<float> final_observation;    ///< kSameStep: before the reset, where the episode ended
  Column<float> final_info;           ///< like final_observation
  Column<float> privileged;           ///< for the critic only, width `width.privileged`
  Column<float> final_privileged;     ///< like final_observation
  std::vector<Column<std::uint8_t>> images;        ///< width `width.images` bytes
  std::vector<Column<std::uint8_t>> final_images;  ///< like final_observation
};

}  // namespace skybody
