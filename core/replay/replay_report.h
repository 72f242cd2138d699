// The first difference between two recordings, or between a recording and its replay.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/io/files/replay_file.h"

namespace skybody {

/// A value that differs.
struct ReplayDifference {
  std::string name;
  std::string first, second;
};

/// The first transition of an environment that differs.
struct ReplayParting {
  std::size_t place = 0;         ///< in the order in which the recording received it, from 0
  std::uint64_t transition = 0;  ///< of the environment since the recording began, from 1
  ReplayRow first, second;
  std::vector<ReplayDifference> differences;  ///< in rows and states; may be empty
};

/// The result of a comparison.
struct ReplayReport {
  std::size_t transitions = 0;         ///< number of compared transitions
  std::size_t parted = 0;              ///< number of environments that differ
  std::optional<ReplayParting> where;  ///< the first of them, in the order of the recording
  /// The reason why the runs cannot be compared to their end, such as "the second ends 40
  /// transitions sooner".
  std::string remark;

  bool identical() const { return parted == 0 && remark.empty(); }
  /// Counts one environment that differs. Keeps the first one.
  void add(ReplayParting parting);
  /// The report, several lines. @param first, second  names of the two runs, such as "recorded"
  std::string text(const ReplayHeader& header, const std::string& first,
                   const std::string& second) const;
};

/// Remark for rows that differ although the hashes are equal: hashes were computed during the run,
/// rows are stored beside them.
inline constexpr const char* kRowsChanged =
    "the hashes are the same, but not the rows beside them: they were changed after the run";

/// The differences between two rows; NaN equals NaN, and -0 differs from 0.
std::vector<ReplayDifference> compare_rows(const ReplayHeader& header, const ReplayRow& first,
                                           const ReplayRow& second);

/// Compares two recordings without running anything.
/// @throws Error if their numbers of environments or widths differ
ReplayReport compare_replays(const ReplayReader& first, const ReplayReader& second);

}  // namespace skybody
