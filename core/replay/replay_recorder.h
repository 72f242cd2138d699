// Records the events of a Pool, for `skybody replay`.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/assemble/compile_scenario.h"
#include "core/batch/pool.h"
#include "core/io/files/replay_file.h"

namespace skybody {

/// Options of a recording.
struct RecordOptions {
  /// Options that loaded the environments: overrides and plugin path are recorded for the replay.
  LoadOptions load = {};
  /// Also records all state words of every transition, so that a replay that differs can list the
  /// words that differ: 8 bytes per word and transition.
  bool states = false;
};

/// A running recording. Rows are recorded when recv() returns them; transitions still in flight at
/// the end are not recorded. If writing fails, the Pool's call throws Error and the recording ends;
/// whole bursts written before are kept.
class ReplayRecorder : public PoolObserver {
 public:
  ~ReplayRecorder() override;

  /// Writes everything so far to the file, which is then complete and readable, even if this
  /// process crashes. Happens automatically every few megabytes.
  void flush();
  /// Ends the recording; later events are ignored. @throws Error if the file cannot be finished
  void close();
  bool recording() const { return writer_.has_value(); }
  const std::filesystem::path& file() const { return file_; }

  void reset_sent(std::span<const std::uint8_t> mask) override;
  void reseeded(std::uint64_t seed) override;
  void actions_sent(std::span<const float> actions, std::span<const std::int32_t> env_ids) override;
  void restored(std::span<const std::uint64_t> saved) override;
  void forked(int source, std::span<const std::int32_t> targets, bool rekey) override;
  void param_set(int env, const std::string& path, double value) override;
  void requested(const PoolRequest& request) override;
  void received(const Batch& rows, const EnvironmentStates& environments) override;

 private:
  friend std::shared_ptr<ReplayRecorder> start_recording(Pool&, const std::filesystem::path&,
                                                         const RecordOptions&);
  ReplayRecorder(const Pool& envs, const std::filesystem::path& file, const RecordOptions& options);
  std::string give_up();
  template <class Write>
  void write(Write&& write);
  void add(ReplayEvent event);

  std::filesystem::path file_;
  std::optional<ReplayWriter> writer_;
  bool same_step_, states_;
  std::vector<std::int32_t> all_ids_, ids_;
  ReplayRow row_;  ///< kept, so that rows are recorded without allocating
};

/// Records all events of `envs` from now on; overwrites an existing file. End it by
/// stop_recording() or by close(). @throws Error if the file cannot be written, or while some
/// environments are in flight
std::shared_ptr<ReplayRecorder> start_recording(Pool& envs, const std::filesystem::path& file,
                                                const RecordOptions& options = {});

/// Ends a recording and detaches it from its Pool. @throws Error if the file cannot be finished
void stop_recording(Pool& envs, ReplayRecorder& recorder);

/// Reads a row of a batch, and the environment's data that the batch does not contain.
/// @param states  whether to copy all state words
void read_row(const Batch& rows, int k, const EnvironmentStates& environments, bool same_step,
              bool states, ReplayRow& out);

}  // namespace skybody
