// Recordings. A changed file must give one of three results: it is refused, its replay reports a
// difference, or every transition read equals the original's.
#include "core/base/math/hash.h"
#include "core/replay/replay_player.h"
#include "core/replay/replay_recorder.h"
#include "tests/fuzz/areas.h"
#include "tests/fuzz/files.h"
#include "tests/fuzz/flight_check.h"
#include "tests/fuzz/plugin_source.h"

namespace skybody::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr int kEnvs = 2, kSteps = 6;
/// Limit on the number of transitions that a changed file may declare; each takes time to replay.
constexpr std::size_t kMostTransitions = 10000;

std::shared_ptr<const CompiledScenario> load_hover() {
  Diagnostics diagnostics;
  LoadOptions options;
  options.scenario = "hover";
  auto compiled = compile_scenario(options, shipped_plugins(), diagnostics);
  diagnostics.throw_if_errors();
  return compiled;
}

/// Actions inside the range, so that a changed bit changes the flight.
std::vector<float> actions_of(int step, int width) {
  std::vector<float> actions(static_cast<std::size_t>(kEnvs * width));
  for (std::size_t k = 0; k < actions.size(); ++k) {
    actions[k] = -0.3f + 0.07f * static_cast<float>(k) + 0.03f * static_cast<float>(step);
  }
  return actions;
}

void receive_all(Pool& envs) {
  while (envs.in_flight() > 0) envs.recv();
}

/// One event of every kind.
void record(const std::shared_ptr<const CompiledScenario>& compiled, const fs::path& file,
            bool states) {
  PoolOptions options;
  options.envs = kEnvs;
  options.threads = 1;
  options.seed = 5;
  Pool envs(compiled, options);
  LoadOptions load;
  load.scenario = "hover";
  const auto recorder = start_recording(envs, file, {load, states});
  envs.send_reset();
  receive_all(envs);
  for (int step = 0; step < kSteps; ++step) {
    if (step == 2) envs.fork(0, std::vector<std::int32_t>{1}, true);
    if (step == 3) envs.set_param(1, "robots.quad.links.base_link.mass", 1.3);
    if (step == 4) envs.send_reset(std::uint64_t{9});
    receive_all(envs);
    envs.send(actions_of(step, compiled->action_size()));
    receive_all(envs);
  }
  stop_recording(envs, *recorder);
}

void add(const ReplayRow& row, HashChain& chain) {
  chain.update(row.env);
  chain.update(row.hash);
  chain.update(row.episode);
  chain.update(row.episode_step);
  chain.update(row.was_reset);
  chain.update(row.status);
  chain.update(hash_bytes(&row.reward, sizeof row.reward));
  chain.update(hash_bytes(row.observation.data(), row.observation.size() * sizeof(float)));
  chain.update(row.state.data(), row.state.size());
}

/// A hash over all transitions and the actions sent.
std::uint64_t digest(const ReplayReader& replay) {
  HashChain chain;
  chain.update(replay.header().envs);
  chain.update(replay.header().scenario_hash);
  chain.update(hash_string(replay.header().autoreset));
  for (std::size_t k = 0; k < replay.transitions(); ++k) add(replay.row(k), chain);
  for (int env = 0; env < replay.header().envs; ++env) {
    for (std::size_t k = 0; k < replay.transitions(env); ++k) {
      const std::vector<float> action = replay.action(env, k);
      chain.update(hash_bytes(action.data(), action.size() * sizeof(float)));
    }
  }
  return chain.value();
}

class ReplayArea : public Area {
 public:
  explicit ReplayArea(const AreaOptions& options) : compiled_(load_hover()) {
    for (const bool states : {false, true}) {
      const fs::path file = options.folder / "seed.replay";
      record(compiled_, file, states);
      material_.seeds.push_back(read_bytes(file));
      originals_.push_back(digest(ReplayReader(file)));
    }
    material_.words = {"skybody-replay", "TREE", "SNOD", "HEAP", "OHDR", "FRHP",   "BTHD",
                       "FADB",           "EAHD", "EASB", "GCOL", "/",    "actions"};
  }

  void begin(const fs::path& folder) override { file_ = folder / "input.replay"; }

  Answer run(const std::string& input, bool) override {
    write_bytes(file_, input);
    try {
      return replay();
    } catch (const Error& error) {
      check_message(error.what());
      return Answer::kRefused;
    }
  }

  /// HDF5 1.10 itself leaks 424 bytes for each damaged object header (H5O_protect, found by
  /// valgrind).
  std::size_t smallest_leak() const override { return 512 * kLeakInputs; }

 private:
  Answer replay() const {
    ReplayReader reader(file_);
    if (reader.transitions() > kMostTransitions) return Answer::kAccepted;
    const ReplayReport report = play(reader, compiled_, 1);
    if (!report.identical()) return Answer::kRefused;
    const std::uint64_t read = digest(reader);
    for (const std::uint64_t original : originals_) {
      if (read == original) return Answer::kAccepted;
    }
    silent_change("the replay is identical, but transitions or actions are other ones (" +
                  std::to_string(report.transitions) + " compared)");
  }

  std::shared_ptr<const CompiledScenario> compiled_;
  std::vector<std::uint64_t> originals_;
  fs::path file_;
};

}  // namespace

std::unique_ptr<Area> make_replay_area(const AreaOptions& options) {
  return std::make_unique<ReplayArea>(options);
}

}  // namespace skybody::fuzz
