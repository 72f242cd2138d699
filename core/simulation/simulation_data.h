// The data of a Simulation. Included by its own files only.
#pragma once

#include <memory>
#include <vector>

#include "core/env/group_workspace.h"
#include "core/simulation/simulation.h"

namespace skybody {

struct Simulation::Data {
  Data(const CompiledScenario& compiled, std::uint64_t seed, std::uint64_t env_id)
      : group(compiled.make_state(1)),
        work(compiled.make_workspace(1)),
        observation(static_cast<std::size_t>(compiled.observation_size())),
        agent_reward(compiled.agents().size()),
        info(static_cast<std::size_t>(compiled.info_size())),
        privileged(static_cast<std::size_t>(compiled.privileged_size())) {
    compiled.initialize(group, 0, seed, env_id);
  }

  Rows rows() {
    return {observation.data(),  &reward,     &status,
            agent_reward.data(), info.data(), privileged.data()};
  }

  StateGroup group;
  std::unique_ptr<GroupWorkspace> work;
  std::vector<BodyState> bodies;  ///< result of the last call of bodies()
  std::vector<float> observation, agent_reward, info, privileged;
  float reward = 0.0f;
  std::uint64_t status = kRunning;
  HashChain chain;
  bool keeps_hash = true;
  using Requests = std::vector<std::shared_ptr<const ParamRequest>>;
  Requests requests_now, requests_at_reset;  ///< requests not yet applied
  bool started = false;
};

}  // namespace skybody
