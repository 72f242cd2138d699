// The transition contract for one world (paper eq. 3): immutable, shared by all environments of a
// scenario. Steps lane groups of state words and stores none itself.
//
// A composition: ScenarioModel holds the data, TransitionPhases the steps of a transition. This
// class gives their order.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/math/hash.h"
#include "core/env/scenario_model.h"
#include "core/env/transition_phases.h"

namespace skybody {

class GroupWorkspace;
class ParamRequest;
class StateValues;

/// One compiled scenario, ready to step. Const methods are safe to call from several threads with
/// different groups and workspaces. step(), reset(), update() and hash() require an FpEnvironment
/// around them: reading the floating-point mode waits for all pending arithmetic, so callers do it
/// once for many groups. The other methods set the mode themselves and restore it.
class CompiledScenario {
 public:
  /// As build_scenario_model().
  CompiledScenario(Scenario scenario, PluginFactory& factory, Checking checking = Checking::kNo);
  ~CompiledScenario();

  const ScenarioModel& model() const { return *model_; }
  const TransitionPhases& phases() const { return phases_; }
  const World& world() const { return *model_->world; }
  const StateLayout& layout() const { return model_->layout(); }
  const Scenario& scenario() const { return model_->scenario(); }
  /// Plugins in the order of the scenario; controllers in robot order.
  const std::vector<PluginInstance>& plugins(SkybodyKind kind) const { return model_->of(kind); }
  const PluginInstance& task() const { return model_->task(); }
  const std::vector<ControllerChain>& chains() const { return model_->chains; }
  const std::vector<Channel>& info_channels() const { return model_->info_channels; }
  int info_size() const { return value_count(info_channels()); }
  /// Channels in the order of the action row.
  const std::vector<ActionChannel>& action_channels() const { return model_->action_channels; }
  int action_size() const { return layout().action.size; }
  /// The columns of the observation: the task's in order, then those added by `observe`.
  const std::vector<ObservationColumn>& columns() const { return model_->observation.columns; }
  /// Number of values in a row of observations, the input of a policy.
  int observation_size() const { return model_->observation.observation_size; }
  /// Number of values in a privileged row, an input of the critic only.
  int privileged_size() const { return model_->observation.privileged_size; }
  /// The images of the observation, in the order of their columns.
  const std::vector<ObservedImage>& images() const { return model_->observation.images; }
  /// Words per environment in a snapshot of a StateGroup.
  std::size_t saved_words() const { return static_cast<std::size_t>(layout().words); }
  /// Readable values of an environment's state, by path.
  const StateValues& state_values() const { return *state_values_; }
  /// Robots that take actions, in order; each is an agent of a multi-agent learner.
  const std::vector<int>& agents() const { return model_->agents; }

  /// The fastest group size for this scenario: kGroupLanes where the physics runs in packs (any
  /// world with the tree dynamics and fixed steps), else 1.
  int preferred_lanes() const {
    return model_->is_checked ? 1 : model_->physics->preferred_lanes();
  }
  StateGroup make_state(int lanes) const { return model_->make_state(lanes); }
  std::unique_ptr<GroupWorkspace> make_workspace(int lanes) const;

  /// Initializes one lane: nominal parameters, episode 0, the given random key. A reset must
  /// follow.
  void initialize(StateGroup& group, int lane, std::uint64_t seed, std::uint64_t stream_env) const {
    phases_.start.initialize(group, lane, seed, stream_env);
  }

  /// Begins the next episode of the lanes in `mask`. Writes their first observation, with reward 0.
  void reset(StateGroup& group, GroupWorkspace& work, std::uint32_t mask, const Rows& rows) const;

  /// One transition of the lanes in `mask`: exactly K physics steps, unless a fault ends the
  /// episode.
  /// @param actions  row of lane l at actions + l * action_stride, each in [-1, 1] (clipped)
  void step(StateGroup& group, GroupWorkspace& work, std::uint32_t mask, const float* actions,
            int action_stride, const Rows& rows) const;

  /// Physics steps of the lanes in `mask` under the commands in the group, without action and task.
  /// Lanes whose physics fails keep their last finite state; their status becomes a fault.
  /// @returns the lanes that succeeded
  std::uint32_t advance(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                        std::int64_t physics_steps) const;

  /// Ends a transition made by advance(): counts one step and evaluates the task.
  void evaluate(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                const Rows& rows) const;

  /// Draws from all randomizers now, regardless of their schedule. Episode and motion continue.
  void randomize(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const;
  /// Applies a caller's request in one lane. Episode and motion continue. Requests for the next
  /// reset go to GroupWorkspace::requests instead.
  void apply(StateGroup& group, GroupWorkspace& work, int lane, const ParamRequest& request) const;

  /// Updates the workspace's bodies and the sensors' inputs after state words were changed from
  /// outside, and draws the images of restored lanes again.
  void update(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const;

  /// Generalised accelerations of one lane now, with the rotor commands, wrenches and drives of the
  /// last physics step.
  /// @param udot  one per u
  /// @throws std::runtime_error if the dynamics fails
  void accelerations(StateGroup& group, GroupWorkspace& work, int lane, double* udot) const;

  /// Contacts of the bodies of one lane with the ground, obstacles and one another.
  std::vector<Contact> contacts(StateGroup& group, GroupWorkspace& work, int lane) const;

  /// The task's goal for each of its goal bodies: 4 values per declared goal, one lane.
  void goal(StateGroup& group, GroupWorkspace& work, int lane, std::vector<double>& out) const;
  /// Motion of the goals: 6 values per declared goal, velocity [m/s] and acceleration [m/s^2], W
  /// axes; 0 if the task does not provide it.
  void goal_motion(StateGroup& group, GroupWorkspace& work, int lane,
                   std::vector<double>& out) const;

  /// The reason for an episode's fault, in words. @param status  EpisodeStatus bits
  /// @returns the reasons, separated by "; "; empty: no fault
  std::string fault_reason(std::uint64_t status) const { return phases_.faults.text(status); }

  /// Adds one transition of a lane to a trajectory hash: state words, observation, privileged row,
  /// images, reward and status.
  void hash(const StateGroup& group, int lane, const Rows& rows, HashChain& chain) const;

 private:
  void fly_action(StateGroup& group, GroupWorkspace& work, SkybodyLanes lanes) const;
  void physics_step(StateGroup& group, GroupWorkspace& work, SkybodyLanes& lanes,
                    std::int64_t steps_left) const;

  std::unique_ptr<const ScenarioModel> model_;
  TransitionPhases phases_;
  std::unique_ptr<const StateValues> state_values_;
};

}  // namespace skybody
