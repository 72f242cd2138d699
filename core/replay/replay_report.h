// Where and how two recordings, or a recording and its replay, part.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/io/replay_file.h"

namespace skybody {

/// A value that differs.
struct ReplayDifference {
  std::string name;
  std::string first, second;
};

/// The first transition of an environment that is not the same in both.
struct ReplayParting {
  std::size_t place = 0;         ///< in the order in which the recording received it, from 0
  std::uint64_t transition = 0;  ///< of the environment since the recording began, from 1
  ReplayRow first, second;
  std::vector<ReplayDifference> differences;  ///< in rows and states; may be empty
};

/// What a comparison came to.
struct ReplayReport {
  std::size_t transitions = 0;         ///< compared
  std::size_t parted = 0;              ///< environments that part
  std::optional<ReplayParting> where;  ///< the first of them, in the order of the recording
  /// Why the runs cannot be compared to their end, such as "the second ends 40 transitions sooner".
  std::string remark;

  bool identical() const { return parted == 0 && remark.empty(); }
  /// Counts one environment that parts and keeps it if it is the first to do so.
  void add(ReplayParting parting);
  /// Several lines. @param first, second  what the two are called, such as "recorded"
  std::string text(const ReplayHeader& header, const std::string& first,
                   const std::string& second) const;
};

/// Remark where rows differ under equal hashes: hashes are of the run, rows lie beside them.
inline constexpr const char* kRowsChanged =
    "the hashes are the same, but not the rows beside them: they were changed after the run";

/// What differs between two rows; NaN equals NaN, and -0 differs from 0.
std::vector<ReplayDifference> compare_rows(const ReplayHeader& header, const ReplayRow& first,
                                           const ReplayRow& second);

/// Compares two recordings without running anything.
/// @throws Error if they are of different numbers of environments or widths
ReplayReport compare_replays(const ReplayReader& first, const ReplayReader& second);

}  // namespace skybody
