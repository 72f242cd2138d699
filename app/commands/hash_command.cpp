// skybody hash: prints one line to compare trajectories between machines, builds or runs.
#include <spdlog/spdlog.h>

#include <cstdio>
#include <filesystem>
#include <span>
#include <vector>

#include "app/arguments.h"
#include "app/commands/command.h"
#include "app/interrupt.h"
#include "app/pool_options.h"
#include "app/scenario_options.h"
#include "core/base/math/hash.h"
#include "core/base/math/random.h"
#include "core/base/system/error.h"
#include "core/batch/motion_hash.h"
#include "core/io/files/flight_log.h"
#include "core/replay/replay_recorder.h"

namespace skybody {
namespace {

constexpr std::uint64_t kMost = 1000000000000;

constexpr const char* kHashFooter =
    "Each environment takes a reset and then exactly K steps; the step after the end of an\n"
    "episode is a reset. Its hash is a chain over state words, observation, privileged row,\n"
    "images, reward and status after each step. The actions of step k of environment e are\n"
    "uniform in [-1, 1], drawn from Philox with key (seed, e), step k, stream `hash.action`.\n"
    "The chains are combined in the order of the environments. The hash does not depend on\n"
    "--threads, --batch and --order.\n"
    "Ctrl-C ends a recording after the current steps; the file is kept, exit status 130.\n"
    "--motion prints a second line: the hash over q, u and rotor speeds instead of all state\n"
    "words. It does not change if a version of Skybody has other state words.\n"
    "Examples:\n"
    "  skybody hash hover --steps 20000 --seed 7\n"
    "  skybody hash payload --envs 12 --threads 4 --batch 4 --order arrival\n"
    "  skybody hash hover --envs 8 --record run.h5 && skybody replay run.h5 --threads 2";

struct HashOptions {
  LoadOptions load;
  PoolOptions envs = {.threads = 1};
  std::uint64_t steps = 1000;
  std::filesystem::path record;
  bool states = false;
  bool motion = false;
};

/// Steps every environment again as soon as it returns.
class Run {
 public:
  Run(Pool& envs, std::uint64_t steps)
      : envs_(envs),
        steps_(steps),
        taken_(static_cast<std::size_t>(envs.envs())),
        width_(static_cast<std::size_t>(envs.compiled().action_size())),
        actions_(taken_.size() * width_) {
    ids_.reserve(taken_.size());
  }

  /// Runs until all steps are taken, or until the first Ctrl-C while an InterruptGuard exists.
  void operator()() {
    envs_.send_reset();
    while (envs_.in_flight() > 0) {
      const auto batch = envs_.recv();
      if (InterruptGuard::signal() == 0) send_next(*batch);
    }
  }

 private:
  void send_next(const Batch& batch) {
    ids_.clear();
    for (int k = 0; k < batch.rows; ++k) {
      const std::int32_t env = batch.env_id[static_cast<std::size_t>(k)];
      std::uint64_t& taken = taken_[static_cast<std::size_t>(env)];
      if (taken == steps_) continue;
      draw(env, taken++, actions_.data() + ids_.size() * width_);
      ids_.push_back(env);
    }
    if (!ids_.empty()) envs_.send(std::span(actions_).first(ids_.size() * width_), ids_);
  }

  void draw(std::int32_t env, std::uint64_t step, float* action) const {
    const RandomKey key{envs_.options().seed, static_cast<std::uint64_t>(env)};
    Random<double> random(key, 0, step, derive_stream("hash.action"));
    for (std::size_t k = 0; k < width_; ++k) {
      action[k] = static_cast<float>(random.uniform(-1.0, 1.0));
    }
  }

  Pool& envs_;
  std::uint64_t steps_;
  std::vector<std::uint64_t> taken_;  ///< steps taken by each environment
  std::size_t width_;
  std::vector<float> actions_;
  std::vector<std::int32_t> ids_;
};

/// Runs with a recording. After an interruption the recorded part is kept. @returns the signal or 0
int record(Pool& envs, Run& run, const HashOptions& options) {
  skip_hdf5_cleanup_at_exit();
  const InterruptGuard guard;
  const auto recorder = start_recording(envs, options.record, {options.load, options.states});
  run();
  stop_recording(envs, *recorder);
  if (InterruptGuard::signal() != 0) {
    spdlog::warn("interrupted; what was done so far is in {}", options.record.string());
  }
  return InterruptGuard::signal();
}

void check(const HashOptions& options) {
  if (options.states && options.record.empty()) {
    throw Error("--states is given without --record FILE, where they would be written");
  }
  if (options.motion && !options.record.empty()) {
    throw Error("--motion does not go with --record FILE: give one of them");
  }
}

int hash(const HashOptions& options) {
  check(options);
  const auto compiled = load_and_warn(options.load);
  PoolOptions how = options.envs;
  how.keep_hash = true;
  Pool envs(compiled, how);
  Run run(envs, options.steps);
  const auto motion = options.motion ? std::make_shared<MotionHash>(envs) : nullptr;
  if (motion) envs.observe(motion);
  if (options.record.empty()) {
    run();
  } else if (const int signal = record(envs, run, options); signal != 0) {
    return kExitSignal + signal;
  }
  std::printf("%s\n", to_hex(envs.hash()).c_str());
  if (motion) std::printf("%s\n", to_hex(motion->value()).c_str());
  return kExitDone;
}

}  // namespace

void add_hash_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("hash", "Print a hash of all states of a flight");
  const auto options = std::make_shared<HashOptions>();
  command->footer(kHashFooter);
  add_scenario_options(*command, options->load);
  add_checked(*command, options->load);
  add_pool_options(*command, options->envs);
  command->add_option("--steps", options->steps, "Steps per environment (1000)")
      ->type_name("K")
      ->check(whole_number(1, kMost));
  command->add_option("--seed", options->envs.seed, "Key of all random numbers (0)")
      ->type_name("S")
      ->check(whole_number(0, UINT64_MAX));
  command->add_option("--record", options->record, "Write a recording for `skybody replay`")
      ->type_name("FILE");
  command->add_flag("--states", options->states,
                    "Record all state words, so that a replay that differs can name them");
  command->add_flag("--motion", options->motion, "Also print the hash of only the motion");
  command->callback([options, &chosen] { chosen = [options] { return hash(*options); }; });
}

}  // namespace skybody
