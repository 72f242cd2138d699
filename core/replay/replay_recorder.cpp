#include "core/replay/replay_recorder.h"

#include <cstring>
#include <numeric>
#include <utility>

#include "core/base/system/error.h"
#include "core/batch/environment_states.h"
#include "core/env/value_names.h"
#include "core/io/files/file.h"
#include "core/version.h"

namespace skybody {
namespace {

ReplayHeader describe(const Pool& envs, const RecordOptions& options) {
  const CompiledScenario& compiled = envs.compiled();
  const Scenario& scenario = compiled.scenario();
  ReplayHeader header;
  header.scenario_name = scenario.name;
  header.scenario_file = absolute_path(scenario.file);
  header.scenario_text = scenario.text;
  header.scenario_hash = scenario.hash;
  header.overrides = options.load.overrides;
  for (const auto& folder : options.load.plugin_path) {
    header.plugin_path.push_back(absolute_path(folder.string()));
  }
  header.skybody_version = version();
  header.seed = envs.options().seed;
  header.first_env_id = envs.options().first_env_id;
  header.envs = envs.envs();
  header.autoreset = to_text(envs.options().autoreset);
  header.action_size = compiled.action_size();
  header.columns = column_texts(compiled);
  header.observation_names = observation_names(compiled);
  for (std::string& name : privileged_names(compiled)) {
    header.observation_names.push_back(std::move(name));
  }
  if (options.states) header.state_names = state_names(compiled);
  return header;
}

void append_row(const Column<float>& rows, int row, int width, std::vector<float>& out) {
  const auto first = rows.begin() + static_cast<std::ptrdiff_t>(row) * width;
  out.insert(out.end(), first, first + width);
}

}  // namespace

void read_row(const Batch& rows, int k, const EnvironmentStates& environments, bool same_step,
              bool states, ReplayRow& out) {
  const auto at = static_cast<std::size_t>(k);
  out.env = rows.env_id[at];
  out.hash = environments.hash(out.env);
  out.episode_step = rows.episode_step[at];
  out.was_reset = rows.was_reset[at] != 0;
  out.status = rows.status[at];
  out.reward = rows.reward[at];
  out.observation.clear();
  append_row(rows.observation, k, rows.width.observation, out.observation);
  append_row(rows.privileged, k, rows.width.privileged, out.observation);
  // Under kSameStep, if an episode has ended, the state is already that of the next episode.
  const bool has_moved_on = same_step && out.status != kRunning && !out.was_reset;
  out.episode = environments.episode(out.env) - (has_moved_on ? 1 : 0);
  if (states) out.state = environments.words(out.env);
}

ReplayRecorder::ReplayRecorder(const Pool& envs, const std::filesystem::path& file,
                               const RecordOptions& options)
    : file_(file),
      same_step_(envs.options().autoreset == Autoreset::kSameStep),
      states_(options.states),
      all_ids_(static_cast<std::size_t>(envs.envs())) {
  std::iota(all_ids_.begin(), all_ids_.end(), 0);
  const std::vector<std::uint64_t> saved = envs.save();
  writer_.emplace(file, describe(envs, options));
  restored(saved);
  flush();
}

ReplayRecorder::~ReplayRecorder() = default;

/// Whether a file that could not be finished can be replayed, up to its last burst.
bool can_be_replayed(const std::filesystem::path& file) {
  try {
    const ReplayReader reader(file);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

/// Ends a recording whose writing failed. @returns a message about the state of its file
std::string ReplayRecorder::give_up() {
  writer_.reset();
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file_, ignored)) return "the recording has ended";
  if (can_be_replayed(file_)) {
    return "the recording has ended; the file is kept and can be replayed up to the last burst "
           "that was written whole";
  }
  std::filesystem::remove(file_, ignored);
  return "the recording has ended, and the file is removed: no burst with transitions in it can be "
         "read";
}

/// Writes if the recording is open; a failure ends the recording.
template <class Write>
void ReplayRecorder::write(Write&& write) {
  if (!writer_) return;
  try {
    write(*writer_);
  } catch (const Error& error) {
    throw Error(std::string(error.what()) + "; " + give_up());
  } catch (...) {
    give_up();
    throw;
  }
}

void ReplayRecorder::add(ReplayEvent event) {
  write([&](ReplayWriter& writer) { writer.add(event); });
}

void ReplayRecorder::flush() {
  write([](ReplayWriter& writer) { writer.flush(); });
}

void ReplayRecorder::close() {
  write([](ReplayWriter& writer) { writer.close(); });
  writer_.reset();
}

void ReplayRecorder::reset_sent(std::span<const std::uint8_t> mask) {
  ids_.clear();
  for (std::size_t env = 0; env < mask.size(); ++env) {
    if (mask[env] != 0) ids_.push_back(static_cast<std::int32_t>(env));
  }
  write([&](ReplayWriter& writer) { writer.add(ReplayEventKind::kReset, ids_, {}); });
}

void ReplayRecorder::reseeded(std::uint64_t seed) {
  ReplayEvent event;
  event.kind = ReplayEventKind::kReseed;
  event.argument = seed;
  add(std::move(event));
}

void ReplayRecorder::actions_sent(std::span<const float> actions,
                                  std::span<const std::int32_t> env_ids) {
  const std::span<const std::int32_t> ids = env_ids.empty() ? all_ids_ : env_ids;
  write([&](ReplayWriter& writer) { writer.add(ReplayEventKind::kSend, ids, actions); });
}

void ReplayRecorder::restored(std::span<const std::uint64_t> saved) {
  ReplayEvent event;
  event.kind = ReplayEventKind::kRestore;
  event.saved.assign(saved.begin(), saved.end());
  add(std::move(event));
}

void ReplayRecorder::forked(int source, std::span<const std::int32_t> targets, bool rekey) {
  ReplayEvent event;
  event.kind = ReplayEventKind::kFork;
  event.env_ids.push_back(source);
  event.env_ids.insert(event.env_ids.end(), targets.begin(), targets.end());
  event.argument = rekey ? 1 : 0;
  add(std::move(event));
}

void ReplayRecorder::param_set(int env, const std::string& path, double value) {
  ReplayEvent event;
  event.kind = ReplayEventKind::kSetParam;
  event.env_ids.push_back(env);
  std::memcpy(&event.argument, &value, sizeof(value));
  event.path = path;
  add(std::move(event));
}

void ReplayRecorder::requested(const PoolRequest& request) {
  ReplayEvent event;
  event.kind = ReplayEventKind::kRequest;
  const std::span<const std::int32_t> ids = request.env_ids.empty() ? all_ids_ : request.env_ids;
  event.env_ids.assign(ids.begin(), ids.end());
  event.argument =
      (request.when == RequestTime::kNextReset ? 1u : 0u) | (request.redraws ? 2u : 0u);
  for (const ParamChange& change : request.changes) event.path += change.text() + "\n";
  add(std::move(event));
}

void ReplayRecorder::received(const Batch& rows, const EnvironmentStates& environments) {
  write([&](ReplayWriter& writer) {
    for (int k = 0; k < rows.rows; ++k) {
      read_row(rows, k, environments, same_step_, states_, row_);
      writer.add(row_);
    }
  });
}

std::shared_ptr<ReplayRecorder> start_recording(Pool& envs, const std::filesystem::path& file,
                                                const RecordOptions& options) {
  std::shared_ptr<ReplayRecorder> recorder(new ReplayRecorder(envs, file, options));
  envs.observe(recorder);
  return recorder;
}

void stop_recording(Pool& envs, ReplayRecorder& recorder) {
  envs.observe(nullptr);
  recorder.close();
}

}  // namespace skybody
