#include "app/physics_cost.h"

#include <chrono>

#include "core/base/fp_environment.h"
#include "core/env/group_work.h"

namespace skybody {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kSeconds = 0.3;
constexpr int kRun = 50;  // steps from the start, so that the world stays near it

}  // namespace

double physics_step_cost(const Environment& environment) {
  StateGroup group = environment.make_state(1);
  const std::unique_ptr<GroupWork> work = environment.make_work(1);
  std::vector<float> observation(static_cast<std::size_t>(environment.observation_size()));
  float reward = 0.0f;
  std::uint64_t status = 0;
  const Rows rows{observation.data(), &reward, &status, nullptr, nullptr};
  environment.initialize(group, 0, 0, 0);
  environment.reset(group, *work, 1u, rows);
  const FpEnvironment guard;
  const std::vector<std::uint64_t> start = group.save(0);
  std::uint64_t steps = 0;
  double seconds = 0.0;
  while (seconds < kSeconds) {
    group.restore(0, start);
    group.refresh(1u, work->physics);
    const GroupBlocks blocks = group.blocks();
    const Clock::time_point begin = Clock::now();
    for (int k = 0; k < kRun; ++k) group.stepper().advance(blocks, 1u, work->physics);
    seconds += std::chrono::duration<double>(Clock::now() - begin).count();
    steps += kRun;
  }
  return seconds / static_cast<double>(steps);
}

}  // namespace skybody
