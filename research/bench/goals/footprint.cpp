#include "research/bench/goals/footprint.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <vector>

#include "core/base/simd/lane_mask.h"
#include "core/batch/pool.h"
#include "core/env/group_workspace.h"
#include "research/bench/bare_simbody.h"

namespace skybody::bench {
namespace {

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  long size = 0, resident = 0;
  file >> size >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace

double bytes_per_environment(const LoadOptions& scenario, int envs) {
  const auto compiled = compile_scenario(scenario);
  const auto fill = [&](int count) {
    PoolOptions options;
    options.envs = count;
    Pool pool(compiled, options);
    const std::vector<float> actions(static_cast<std::size_t>(count) * 4, 0.2f);
    pool.send_reset();
    for (int round = 0; round < 4; ++round) {  // allocates both rotating buffers
      pool.recv();
      pool.send(actions);
    }
    pool.recv();
    return resident_bytes();
  };
  fill(64);  // allocates everything that is independent of the number
  malloc_trim(0);
  const double before = resident_bytes();
  return (fill(envs) - before - 4.0 * 4.0 * envs) / envs;  // without our own actions
}

double reset_time(const LoadOptions& scenario) {
  constexpr int kTrials = 200, kResets = 50;
  const auto compiled = compile_scenario(scenario);
  const int lanes = compiled->preferred_lanes();
  StateGroup group = compiled->make_state(lanes);
  const std::unique_ptr<GroupWorkspace> work = compiled->make_workspace(lanes);
  const auto count = static_cast<std::size_t>(lanes);
  std::vector<float> observation(count * static_cast<std::size_t>(compiled->observation_size()));
  std::vector<float> reward(count);
  std::vector<std::uint64_t> status(count);
  for (int l = 0; l < lanes; ++l) {
    compiled->initialize(group, l, 0, static_cast<std::uint64_t>(l));
  }
  // A reset defers some work to the next step. That work belongs to the reset, so the time of a
  // plain step is subtracted.
  const std::uint32_t all = first_lanes(lanes);
  const std::vector<float> actions(count * static_cast<std::size_t>(compiled->action_size()));
  const Rows rows{observation.data(), reward.data(), status.data()};
  const auto time_of = [&](bool with_reset) {
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < kResets; ++k) {
      if (with_reset) compiled->reset(group, *work, all, rows);
      compiled->step(group, *work, all, actions.data(), compiled->action_size(), rows);
    }
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    return time.count() / (kResets * lanes);
  };
  double both = 1e300, step = 1e300;
  for (int trial = 0; trial < kTrials; ++trial) {
    both = std::min(both, time_of(true));
    step = std::min(step, time_of(false));
  }
  return both - step;
}

double bare_rebuild_time() {
  constexpr int kTrials = 100, kRebuilds = 20;
  const auto world = make_bare_loop(true);
  double best = 1e300;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < kRebuilds; ++k) world->rebuild(0.9 + 0.01 * k);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    best = std::min(best, time.count() / kRebuilds);
  }
  return best;
}

}  // namespace skybody::bench
