#include "app/commands/physics_cost.h"

#include <chrono>

#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "core/env/group_workspace.h"

namespace skybody {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kSeconds = 0.3;
constexpr int kRun = 50;  // steps from the start; few, so that the state stays near it

}  // namespace

double physics_step_cost(const CompiledScenario& compiled, int side_by_side) {
  const int room = side_by_side > 1 ? compiled.preferred_lanes() : 1, lanes = side_by_side;
  StateGroup group = compiled.make_state(room);
  const std::unique_ptr<GroupWorkspace> work = compiled.make_workspace(room);
  const auto rows = static_cast<std::size_t>(room);
  std::vector<float> observation(static_cast<std::size_t>(compiled.observation_size()) * rows);
  std::vector<float> reward(rows);
  std::vector<std::uint64_t> status(rows);
  const std::uint32_t all = first_lanes(lanes);
  for (int l = 0; l < lanes; ++l) compiled.initialize(group, l, 0, static_cast<std::uint64_t>(l));
  const FpEnvironment guard;
  compiled.reset(group, *work, all, {observation.data(), reward.data(), status.data()});
  std::vector<std::vector<std::uint64_t>> start;
  for (int l = 0; l < lanes; ++l) start.push_back(group.save(l));
  std::uint64_t steps = 0;
  double seconds = 0.0;
  while (seconds < kSeconds) {
    for (int l = 0; l < lanes; ++l) group.restore(l, start[static_cast<std::size_t>(l)]);
    group.refresh(all, work->physics);
    const Clock::time_point begin = Clock::now();
    for (int k = 0; k < kRun; ++k) group.advance(all, work->physics);
    seconds += std::chrono::duration<double>(Clock::now() - begin).count();
    steps += static_cast<std::uint64_t>(kRun * lanes);
  }
  return seconds / static_cast<double>(steps);
}

}  // namespace skybody
