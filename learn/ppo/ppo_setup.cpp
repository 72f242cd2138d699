#include "learn/ppo/ppo_setup.h"

#include <limits>
#include <string>

#include "core/base/system/error.h"

namespace skybody::learn {
namespace {

void refuse_no_actions(const CompiledScenario& compiled, const AgentTable& agents) {
  if (agents.action_size() > 0) return;
  throw Error("`" + compiled.scenario().name +
              "` takes no actions, so that there is nothing to learn: take away the controller "
              "that decides, such as `reference`");
}

void check_together(const Hyperparameters& hyper, int agent_rows) {
  const std::int64_t rows = std::int64_t{hyper.envs} * hyper.rollout_steps * agent_rows;
  if (rows > std::numeric_limits<int>::max()) {
    throw Error("a rollout has " + std::to_string(rows) +
                " rows (envs * rollout_steps, with shared_policy times the robots): allowed are " +
                std::to_string(std::numeric_limits<int>::max()) + "; take fewer");
  }
  if (hyper.minibatch > rows) {
    throw Error("hyper-parameter minibatch = " + std::to_string(hyper.minibatch) +
                ": allowed is 2 to the rows of a rollout, " + std::to_string(rows) +
                " (envs * rollout_steps, with shared_policy times the robots)");
  }
  if (hyper.squashed && hyper.bounded_mean) {
    throw Error("hyper-parameters squashed and bounded_mean exclude one another: set one to false");
  }
}

}  // namespace

PpoSetup::PpoSetup(const LearnerOptions& options)
    : compiled(options.compiled),
      hyper((check(options.hyper, Algorithm::kFastPpo), options.hyper)),
      seed(options.seed),
      total_steps(options.total_steps),
      isa(best_isa()),
      agents(make_agent_table(*compiled, hyper.shared_policy)),
      images(find_images(*compiled, hyper, std::int64_t{hyper.envs} * (hyper.rollout_steps + 1))),
      plan((check_together(hyper, agents.rows()), hyper.envs), hyper.rollout_steps * agents.rows(),
           hyper.minibatch, hyper.recurrent_units > 0 ? hyper.rollout_steps : 1),
      row{agents.observation_size() + agents.privileged_size(), agents.action_size()},
      error(find_position_error(*compiled)) {
  refuse_no_actions(*compiled, agents);
}

}  // namespace skybody::learn
