// Conversions between rows of learners (one per environment, float) and values of a group (in
// lanes, double): reads actions and writes the results of a transition.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "core/base/simd/isa.h"

namespace skybody {

/// Consecutive values of a row.
struct ValueRun {
  int first = 0, count = 0;
};
/// Consecutive values of a row that repeat other values of the same row.
struct ValueCopy {
  int from = 0, to = 0, count = 0;
};

/// A piece of a row: some values are written, others copied. Either part may be empty.
struct RowPiece {
  ValueRun written;
  ValueCopy copied;
};

/// The sources of a row's values: some are written, the others are copied from these.
struct RowParts {
  int size = 0;                   ///< values in a row
  std::vector<ValueRun> written;  ///< in order
  std::vector<ValueCopy> copies;  ///< in order
  std::vector<RowPiece> pieces;   ///< all runs and copies: sources of copies first, then in order

  /// Computes `pieces` from the other members.
  void set_pieces();

  /// The value that value k copies; k itself if it is not a copy or lies outside the row.
  int source_of(int k) const {
    const auto after = std::upper_bound(copies.begin(), copies.end(), k,
                                        [](int value, const ValueCopy& c) { return value < c.to; });
    if (after == copies.begin()) return k;
    const ValueCopy& copy = *std::prev(after);
    return k < copy.to + copy.count ? copy.from + (k - copy.to) : k;
  }
};

/// Fills in the copies of one row.
void copy_repeats(const RowParts& parts, float* row);

/// The kernels for one instruction set; all give the same bits. They serve any lanes of a group of
/// 1 or kGroupLanes lanes. Rows and words of the other lanes are neither read nor written, except
/// by `copy`.
/// @param mask   the lanes to serve
/// @param lanes  of the group: value k of lane l is at k * lanes + l
struct RowKernels {
  /// Reads values and clips them to [-1, 1].
  /// @param rows    row of lane l at rows + l * stride, `count` values each
  /// @param values  `count` values in lanes
  /// @returns the lanes whose rows are finite; the rows of other lanes are ignored
  std::uint32_t (*read_clipped_actions)(std::uint32_t mask, int lanes, const float* rows,
                                        std::ptrdiff_t stride, int count, double* values);

  /// low + (a + 1) / 2 (high - low) for each of `count` values.
  void (*scale)(std::uint32_t mask, int lanes, const double* action, int count, const double* low,
                const double* high, double* command);

  /// Copies `count` values in a group of kGroupLanes. Reads and writes other lanes too, but keeps
  /// their values.
  void (*copy)(std::uint32_t mask, const double* from, int count, double* to);

  /// Writes the same values to each lane: value k of `count` is values[k % size].
  void (*fill)(std::uint32_t mask, int lanes, const double* values, int size, int count,
               double* to);

  /// @param counts  1 word per lane, below 2^52
  /// @param period  1 to 2^52
  /// @returns the lanes whose count is a multiple of the period
  std::uint32_t (*multiples)(std::uint32_t mask, const std::uint64_t* counts, double period);

  /// Adds one to a word of each lane.
  void (*count)(std::uint32_t mask, std::uint64_t* words);

  /// @returns the lanes whose values are all finite as floats
  std::uint32_t (*are_finite)(std::uint32_t mask, int lanes, const double* values, int count);

  /// @param values  `count` values in lanes
  /// @param rows    output as floats, finite or not; row of lane l at rows + l * count
  /// @returns as are_finite
  std::uint32_t (*write)(std::uint32_t mask, int lanes, const double* values, int count,
                         float* rows);

  /// As `write`, for rows of which only some values are in lanes, at their places; the rest is
  /// copied.
  std::uint32_t (*write_parts)(std::uint32_t mask, int lanes, const double* values,
                               const RowParts& parts, float* rows);

  /// Whether the task or the horizon ends the episode.
  /// @param by_task  the task's bits, 1 word per lane: kTerminated and kTruncated are used
  /// @param step     actions taken in the episode, 1 word per lane
  /// @param horizon  number of actions after which an episode is truncated; 0: never
  /// @param status   EpisodeStatus bits, 1 word per lane
  /// @param rows     receives a copy of status
  void (*end)(std::uint32_t mask, const std::uint64_t* by_task, const std::uint64_t* step,
              std::uint64_t horizon, std::uint64_t* status, std::uint64_t* rows);
};

RowKernels row_kernels(Isa isa);
/// Kernels of the best available instruction set (best_isa), chosen once.
const RowKernels& row_kernels();

}  // namespace skybody
