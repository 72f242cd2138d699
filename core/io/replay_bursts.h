// The bursts of a replay file: how far it is complete, and the hash of all that it holds.
//
// A recording is written in bursts. Each ends with a row of /bursts: the rows that every column has
// by then, and the hash chain over the header and all values so far. The reader takes no row that
// no burst names, and hashes every value again. So a file that was cut off while it was written is
// read up to its last burst, and a value that has changed since is found wherever HDF5 keeps it.
#pragma once

#include <hdf5.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/hash.h"
#include "core/io/replay_file.h"

namespace skybody {

class Hdf5Reader;

/// How many values a row of a column has.
enum class ReplayWidth : std::uint8_t { kOne, kAction, kObservation, kState };

enum class ReplayType : std::uint8_t { kU8, kI32, kU64, kF32 };

struct ReplayColumn {
  const char* path;
  ReplayType type;
  ReplayWidth width;
};

/// Places of the columns in kReplayColumns; plain numbers, as indices are.
struct ReplayColumnId {
  enum Id : std::uint8_t {
    kKind,
    kCount,
    kArgument,
    kEventEnv,
    kAction,
    kPath,
    kSaved,
    kRowEnv,
    kHash,
    kEpisode,
    kEpisodeStep,
    kWasReset,
    kStatus,
    kReward,
    kObservation,
    kState
  };
};
inline constexpr std::size_t kReplayColumnCount = ReplayColumnId::kState + 1;

/// In the order in which bursts count and hash them.
inline constexpr std::array<ReplayColumn, kReplayColumnCount> kReplayColumns = {{
    {"/events/kind", ReplayType::kU8, ReplayWidth::kOne},
    {"/events/count", ReplayType::kU64, ReplayWidth::kOne},
    {"/events/argument", ReplayType::kU64, ReplayWidth::kOne},
    {"/events/env_id", ReplayType::kI32, ReplayWidth::kOne},
    {"/events/action", ReplayType::kF32, ReplayWidth::kAction},
    {"/events/path", ReplayType::kU8, ReplayWidth::kOne},
    {"/events/saved", ReplayType::kU64, ReplayWidth::kOne},
    {"/transitions/env_id", ReplayType::kI32, ReplayWidth::kOne},
    {"/transitions/hash", ReplayType::kU64, ReplayWidth::kOne},
    {"/transitions/episode", ReplayType::kU64, ReplayWidth::kOne},
    {"/transitions/episode_step", ReplayType::kI32, ReplayWidth::kOne},
    {"/transitions/was_reset", ReplayType::kU8, ReplayWidth::kOne},
    {"/transitions/status", ReplayType::kU64, ReplayWidth::kOne},
    {"/transitions/reward", ReplayType::kF32, ReplayWidth::kOne},
    {"/transitions/observation", ReplayType::kF32, ReplayWidth::kObservation},
    {"/transitions/state", ReplayType::kU64, ReplayWidth::kState},
}};

inline constexpr const char* kReplayBursts = "/bursts";
/// Of a row of /bursts: a count per column, then the hash.
inline constexpr int kReplayBurstWidth = kReplayColumnCount + 1;

/// Values in a row of the column; 0: the recording does not have it.
std::size_t replay_width(const ReplayHeader& header, ReplayWidth width);

/// The chain that the values of a recording are added to: all fields of its header.
HashChain replay_chain(const ReplayHeader& header);

/// Adds what one burst gives one column. @param rows  that the column has with them
void add_burst(HashChain& chain, std::uint64_t rows, const void* values, std::size_t bytes);

/// Rows of each column.
using ReplayRows = std::array<std::size_t, kReplayColumnCount>;

/// The rows of the complete bursts of a file.
/// @throws LocatedError where a column is missing, is of another type or width, or has other values
///         than were written
ReplayRows check_bursts(const Hdf5Reader& reader, const ReplayHeader& header);

}  // namespace skybody
