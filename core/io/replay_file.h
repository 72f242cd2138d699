// The replay file: what was sent to a batch of environments and what came back, so that a run can
// be repeated and compared bit for bit. docs/replay.md has the format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace skybody {

/// What holds for the whole recording.
struct ReplayHeader {
  std::string scenario_name, scenario_file, scenario_text;
  std::uint64_t scenario_hash = 0;
  std::vector<std::string> overrides;    ///< as for --set
  std::vector<std::string> plugin_path;  ///< folders that were searched first
  std::string skybody_version;
  std::uint64_t seed = 0, first_env_id = 0;
  int envs = 0;
  std::string autoreset;  ///< next_step, same_step, disabled
  int action_size = 0;
  std::vector<std::string> columns;            ///< of the observation, a text each, see replay.md
  std::vector<std::string> observation_names;  ///< one per value, the privileged ones last
  std::vector<std::string> state_names;        ///< one per state word; empty: states not recorded
};

enum class ReplayEventKind : std::uint8_t {
  kRestore,   ///< the environments were put in a saved state; the first event of every recording
  kReset,     ///< resets were sent to `env_ids`
  kSend,      ///< actions were sent to `env_ids`
  kFork,      ///< `env_ids` are the source, then its targets; argument 1: rekeyed
  kSetParam,  ///< of one environment; argument: the value's bits
  kReseed,    ///< back to the beginning under another seed (argument), resets sent to all
  kRequest,  ///< `env_ids` were asked for changes (path: a line each); argument: bit 0: at the next
             ///< reset, bit 1: all randomizers draw
};

/// Whether an event of a kind has a text.
constexpr bool has_path_text(ReplayEventKind kind) {
  return kind == ReplayEventKind::kSetParam || kind == ReplayEventKind::kRequest;
}

/// Something that was done to the environments, in the order in which it was done.
struct ReplayEvent {
  ReplayEventKind kind = ReplayEventKind::kReset;
  std::vector<std::int32_t> env_ids;
  std::vector<float> actions;        ///< kSend: a row per id
  std::uint64_t argument = 0;        ///< see the kinds
  std::string path;                  ///< kSetParam, kRequest
  std::vector<std::uint64_t> saved;  ///< kRestore: what Pool::save() gave
};

/// A finished transition of one environment.
struct ReplayRow {
  int env = 0;
  std::uint64_t hash = 0;         ///< the environment's chain after it
  std::uint64_t episode = 0;      ///< that the row is of, from 1
  std::int32_t episode_step = 0;  ///< actions taken in it
  bool was_reset = false;
  std::uint64_t status = 0;  ///< EpisodeStatus bits
  float reward = 0.0f;
  std::vector<float> observation;    ///< the privileged values last
  std::vector<std::uint64_t> state;  ///< all words, where the recording has them
};

/// Writes a replay file. Everything waits in memory until flush() or until about 4 MiB are
/// together; between flushes the file on disk is complete and readable, also after a crash.
class ReplayWriter {
 public:
  /// Replaces a file that is there. @throws Error with the file's name and the reason
  ReplayWriter(const std::filesystem::path& file, const ReplayHeader& header);
  ~ReplayWriter();  ///< closes; a failure is lost
  ReplayWriter(const ReplayWriter&) = delete;
  ReplayWriter& operator=(const ReplayWriter&) = delete;

  void add(const ReplayEvent& event);
  /// The same without copies: kSend, kReset and others that have ids and rows alone.
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

/// Reads a replay file. Actions and rows are read when asked for; all have been hashed before.
class ReplayReader {
 public:
  /// @throws LocatedError with the file's name: missing, no replay, another version, damaged
  explicit ReplayReader(const std::filesystem::path& file);
  ~ReplayReader();
  ReplayReader(const ReplayReader&) = delete;
  ReplayReader& operator=(const ReplayReader&) = delete;

  const ReplayHeader& header() const;
  const std::filesystem::path& file() const;

  /// The next event. @returns false after the last
  bool next(ReplayEvent& event);

  /// Finished transitions, in the order in which they were received.
  std::size_t transitions() const;
  std::size_t transitions(int env) const;  ///< of one environment
  /// Place of the k-th transition (from 0) of an environment in that order.
  std::size_t place(int env, std::size_t k) const;
  std::uint64_t hash(std::size_t place) const;
  ReplayRow row(std::size_t place) const;
  /// The action row that the k-th transition of an environment was given; empty for a reset that
  /// was asked for.
  std::vector<float> action(int env, std::size_t k) const;

 private:
  struct Block;
  struct File;
  std::unique_ptr<File> file_;
};

/// The newest format.
inline constexpr int kReplayFormat = 4;

}  // namespace skybody
