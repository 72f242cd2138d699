// The bursts of a replay file: they define its complete part and the hash of its contents.
//
// A recording is written in bursts. Each burst ends with a row of /bursts: the number of rows of
// every column so far, and the hash chain over the header and all values so far. The reader ignores
// rows beyond the last burst and hashes every value again. A file cut off during writing is
// therefore read up to its last burst, and a changed value is detected anywhere in the file.
#pragma once

#include <hdf5.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/math/hash.h"
#include "core/io/files/replay_file.h"

namespace skybody {

class Hdf5Reader;

/// Calls `visit(name, field)` for each field of a header, with its name in the file; for
/// hexadecimal numbers `visit(name, field, 16)`. In the order of the hash.
template <class Header, class Visit>
void each_replay_field(Header& header, Visit&& visit) {
  visit("skybody_version", header.skybody_version);
  visit("scenario", header.scenario_name);
  visit("scenario_file", header.scenario_file);
  visit("scenario_text", header.scenario_text);
  visit("autoreset", header.autoreset);
  visit("scenario_hash", header.scenario_hash, 16);
  visit("seed", header.seed);
  visit("first_env_id", header.first_env_id);
  visit("envs", header.envs);
  visit("action_size", header.action_size);
  visit("overrides", header.overrides);
  visit("plugin_path", header.plugin_path);
  visit("columns", header.columns);
  visit("observation_names", header.observation_names);
  visit("state_names", header.state_names);
}

/// Number of values in a row of a column.
enum class ReplayWidth : std::uint8_t { kOne, kAction, kObservation, kState };

enum class ReplayType : std::uint8_t { kU8, kI32, kU64, kF32 };

struct ReplayColumn {
  const char* path;  ///< "/GROUP/NAME"
  ReplayType type;
  ReplayWidth width;
};

/// Indices of the columns in kReplayColumns, as plain integers.
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

/// In the order of counts and hashes in bursts.
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
/// Values in a row of /bursts: one count per column, then the hash.
inline constexpr int kReplayBurstWidth = kReplayColumnCount + 1;

/// Values in a row of the column; 0: the recording lacks the column.
std::size_t replay_width(const ReplayHeader& header, ReplayWidth width);

/// The initial hash chain of a recording: all fields of its header.
HashChain replay_chain(const ReplayHeader& header);

/// Adds one burst's values of one column. @param rows  total rows of the column after the burst
void add_burst(HashChain& chain, std::uint64_t rows, const void* values, std::size_t bytes);

/// Number of rows of each column.
using ReplayRows = std::array<std::size_t, kReplayColumnCount>;

/// The rows of the complete bursts of a file.
/// @throws LocatedError if a column is missing, is of another type or width, or its values differ
///         from the written ones
ReplayRows check_bursts(const Hdf5Reader& reader, const ReplayHeader& header);

}  // namespace skybody
