// The replay file: the inputs and outputs of a batch of environments, for repeating a run and
// comparing it bit for bit. docs/replay.md has the format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace skybody {

/// Data of the whole recording.
struct ReplayHeader {
  std::string scenario_name, scenario_file, scenario_text;
  std::uint64_t scenario_hash = 0;
  std::vector<std::string> overrides;    ///< arguments of --set
  std::vector<std::string> plugin_path;  ///< folders searched first
  std::string skybody_version;
  std::uint64_t seed = 0, first_env_id = 0;
  int envs = 0;
  std::string autoreset;  ///< next_step, same_step, disabled
  int action_size = 0;
  std::vector<std::string> columns;            ///< of the observation, one text each (replay.md)
  std::vector<std::string> observation_names;  ///< one per value, the privileged ones last
  std::vector<std::string> state_names;        ///< one per state word; empty: states not recorded
};

enum class ReplayEventKind : std::uint8_t {
  kRestore,   ///< the environments got a saved state; the first event of every recording
  kReset,     ///< resets were sent to `env_ids`
  kSend,      ///< actions were sent to `env_ids`
  kFork,      ///< `env_ids` are the source, then its targets; argument 1: rekeyed
  kSetParam,  ///< of one environment; argument: the value's bits
  kReseed,    ///< restart with another seed (argument); resets were sent to all environments
  kRequest,  ///< changes were requested of `env_ids` (path: one line each); argument: bit 0: at the
             ///< next reset, bit 1: all randomizers draw
};

/// Whether an event of a kind has a text.
constexpr bool has_path_text(ReplayEventKind kind) {
  return kind == ReplayEventKind::kSetParam || kind == ReplayEventKind::kRequest;
}

/// One operation on the environments. Events are in the order of execution.
struct ReplayEvent {
  ReplayEventKind kind = ReplayEventKind::kReset;
  std::vector<std::int32_t> env_ids;
  std::vector<float> actions;        ///< kSend: one row per id
  std::uint64_t argument = 0;        ///< see ReplayEventKind
  std::string path;                  ///< kSetParam, kRequest
  std::vector<std::uint64_t> saved;  ///< kRestore: result of Pool::save()
};

/// A finished transition of one environment.
struct ReplayRow {
  int env = 0;
  std::uint64_t hash = 0;         ///< the environment's hash chain after the transition
  std::uint64_t episode = 0;      ///< the row's episode, from 1
  std::int32_t episode_step = 0;  ///< actions taken in the episode
  bool was_reset = false;
  std::uint64_t status = 0;  ///< EpisodeStatus bits
  float reward = 0.0f;
  std::vector<float> observation;    ///< the privileged values last
  std::vector<std::uint64_t> state;  ///< all words, if recorded
};

/// Writes a replay file. Data is buffered until flush() or until about 4 MiB have accumulated.
/// Between flushes the file on disk is complete and readable, also after a crash.
class ReplayWriter {
 public:
  /// Replaces an existing file. @throws Error with the file's name and the reason
  ReplayWriter(const std::filesystem::path& file, const ReplayHeader& header);
  ~ReplayWriter();  ///< closes the file and ignores failures
  ReplayWriter(const ReplayWriter&) = delete;
  ReplayWriter& operator=(const ReplayWriter&) = delete;

  void add(const ReplayEvent& event);
  /// The same without copies: for kSend, kReset and other events with only ids and actions.
  void add(ReplayEventKind kind, std::span<const std::int32_t> env_ids,
           std::span<const float> actions);
  void add(const ReplayRow& row);
  /// @throws Error with the file's name and the reason
  void flush();
  void close();

 private:
  struct File;
  void flush_if_full();
  std::unique_ptr<File> file_;
};

/// Reads a replay file. Actions and rows are read on demand; the constructor has hashed all of
/// them.
class ReplayReader {
 public:
  /// @throws LocatedError with the file's name if it is missing, not a replay, of another version,
  ///         or damaged
  explicit ReplayReader(const std::filesystem::path& file);
  ~ReplayReader();
  ReplayReader(const ReplayReader&) = delete;
  ReplayReader& operator=(const ReplayReader&) = delete;

  const ReplayHeader& header() const;
  const std::filesystem::path& file() const;

  /// The next event. @returns false after the last
  bool next(ReplayEvent& event);

  /// Number of finished transitions, in the order in which they were received.
  std::size_t transitions() const;
  std::size_t transitions(int env) const;  ///< of one environment
  /// Index in that order of the k-th transition (from 0) of an environment.
  std::size_t place(int env, std::size_t k) const;
  std::uint64_t hash(std::size_t place) const;
  ReplayRow row(std::size_t place) const;
  /// The action row of the k-th transition of an environment; empty for an explicit reset.
  std::vector<float> action(int env, std::size_t k) const;

 private:
  struct Block;
  struct File;
  std::unique_ptr<File> file_;
};

/// The latest format version.
inline constexpr int kReplayFormat = 4;

}  // namespace skybody
