// The transition contract for one world (paper eq. 3): immutable, shared by all environments of a
// scenario. Steps lane groups of state words and stores none itself.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/math/hash.h"
#include "core/env/controller_chains.h"
#include "core/env/initial_states.h"
#include "core/env/observation_plan.h"
#include "core/env/plugin_instance.h"
#include "core/env/state_group.h"
#include "core/physics/contact/contact.h"
#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

class GroupWorkspace;
class ParamRequest;
class StartOverlaps;
class StateValues;
struct StartOverlap;

/// Output rows of a transition. The row of lane l begins at l times the row's width.
struct Rows {
  float* observation = nullptr;           ///< width observation_size()
  float* reward = nullptr;                ///< width 1
  std::uint64_t* status = nullptr;        ///< EpisodeStatus bits, width 1
  float* agent_reward = nullptr;          ///< width agents().size(); optional
  float* info = nullptr;                  ///< width info_size(); optional
  float* privileged = nullptr;            ///< width privileged_size(); optional
  std::uint8_t* const* images = nullptr;  ///< one buffer per image, in bytes; optional
};

/// A part of the action row: a channel of the task's own action, or the command of a chain.
struct ActionChannel {
  std::string name;  ///< the task channel's, or the signal's
  std::string unit;  ///< of a task channel
  int robot = 0;
  int first = 0;                  ///< first value within the action row
  std::vector<double> low, high;  ///< physical values of the actions -1 and +1
};

/// Whether to check that plugins touch only the values that they may touch. Checked mode is slower
/// and gives the same bits.
enum class Checking { kNo, kYes };

/// One compiled scenario, ready to step. Const methods are safe to call from several threads with
/// different groups and workspaces. step(), reset(), update() and hash() require an FpEnvironment
/// around them: reading the floating-point mode waits for all pending arithmetic, so callers do it
/// once for many groups. The other methods set the mode themselves and restore it.
class CompiledScenario {
 public:
  /// Configures the plugins and builds the world.
  /// @param checking  kYes: checked mode. Groups have one lane, and calls throw LocatedError where
  ///   a plugin touches values that it may not touch
  /// @throws LocatedError with the scenario's line if a plugin refuses its configuration or signals
  ///   do not match
  CompiledScenario(Scenario scenario, PluginFactory& factory, Checking checking = Checking::kNo);
  ~CompiledScenario();

  const World& world() const { return *world_; }
  const StateLayout& layout() const { return world_->layout; }
  const Scenario& scenario() const { return world_->scenario; }
  /// Plugins in the order of the scenario; controllers in robot order.
  const std::vector<PluginInstance>& plugins(SkybodyKind kind) const { return plugins_[kind]; }
  const PluginInstance& task() const { return plugins_[SKYBODY_TASK][0]; }
  const std::vector<ControllerChain>& chains() const { return chains_; }
  /// The command words of a robot: those of its chains, in order. Size 0: the robot takes no
  /// command.
  Block commands_of(int robot) const;
  /// Values reported beside the observation: the task's, those of other plugins by instance, and
  /// the randomizable values named in the scenario.
  const std::vector<Channel>& info_channels() const { return info_channels_; }
  /// Channels in the order of the action row.
  const std::vector<ActionChannel>& action_channels() const { return action_channels_; }
  int action_size() const { return layout().action.size; }
  /// The columns of the observation: the task's in order, then those added by `observe`.
  const std::vector<ObservationColumn>& columns() const { return plan_.columns; }
  /// Number of values in a row of observations, the input of a policy.
  int observation_size() const { return plan_.observation_size; }
  /// The values of that row that are stored in the state (StateLayout::last_observation), and those
  /// that repeat others.
  const RowParts& observation_row() const { return plan_.row; }
  /// Number of values in a privileged row, an input of the critic only.
  int privileged_size() const { return plan_.privileged_size; }
  /// The images of the observation, in the order of their columns.
  const std::vector<ObservedImage>& images() const { return plan_.images; }
  int info_size() const { return value_count(info_channels_); }
  /// The robots' initial states, as EnvParams.
  const InitialStates& starts() const { return starts_; }
  /// Words per environment in a snapshot of a StateGroup: state words, then images.
  std::size_t saved_words() const {
    return static_cast<std::size_t>(layout().words) + image_words_;
  }
  /// Readable values of an environment's state, by path.
  const StateValues& state_values() const { return *state_values_; }
  /// Robots that take actions, in order; each is an agent of a multi-agent learner.
  const std::vector<int>& agents() const { return agents_; }

  /// Whether the motion of bodies equals q, then u, value by value (one robot, a free body).
  bool bodies_are_coordinates() const { return physics_->bodies_are_coordinates(); }

  /// The fastest group size for this scenario: kGroupLanes where the physics runs in packs (any
  /// world with the tree dynamics and fixed steps), else 1.
  int preferred_lanes() const { return is_checked_ ? 1 : physics_->preferred_lanes(); }
  /// @param lanes  1 or kGroupLanes
  StateGroup make_state(int lanes) const;
  /// Scratch for groups of that size. Results never depend on the groups that used it before.
  std::unique_ptr<GroupWorkspace> make_workspace(int lanes) const;

  /// Initializes one lane: nominal parameters, episode 0, the given random key. A reset must
  /// follow.
  void initialize(StateGroup& group, int lane, std::uint64_t seed, std::uint64_t stream_env) const;

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
  /// outside.
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
  std::string fault_reason(std::uint64_t status) const;

  /// Adds one transition of a lane to a trajectory hash: state words, observation, privileged row,
  /// images, reward and status.
  void hash(const StateGroup& group, int lane, const Rows& rows, HashChain& chain) const;

 private:
  /// Calls the task's goal() or goal_motion(), `size` values per declared goal; null: zeros.
  template <class Function>
  void ask_goals(StateGroup& group, GroupWorkspace& work, int lane, Function function, int size,
                 const char* what, std::vector<double>& out) const;
  friend class TransitionAdjoint;  // runs a step phase by phase, to differentiate it backwards
  friend class DualTransition;     // runs the same phases
  struct Builder;
  SkybodyChecks make_checks() const;
  void apply_action(StateGroup&, GroupWorkspace&, const SkybodyLanes&, const float* actions,
                    int stride) const;
  void make_command(StateGroup&, GroupWorkspace&, const SkybodyLanes&) const;
  void process(StateGroup&, GroupWorkspace&, const SkybodyLanes&) const;
  void scale_action(const StateGroup&, std::uint32_t mask, double* out) const;
  void move_command(StateGroup&, const GroupWorkspace&, std::uint32_t mask, int step, int steps,
                    bool is_first) const;
  void control(StateGroup&, GroupWorkspace&, const SkybodyLanes&) const;
  void control(StateGroup&, GroupWorkspace&, const SkybodyLanes&, const ControllerChain&) const;
  void apply_effects(StateGroup&, const SkybodyLanes&) const;
  void add_up_held(StateGroup&, std::uint32_t mask, int input) const;
  void clear_held(StateGroup&, std::uint32_t mask) const;
  std::uint32_t due(const PluginInstance&, const StateGroup&, std::uint32_t mask) const;
  void fly_action(StateGroup&, GroupWorkspace&, SkybodyLanes lanes) const;
  void physics_step(StateGroup&, GroupWorkspace&, SkybodyLanes& lanes,
                    std::int64_t steps_left) const;
  std::uint32_t advance(StateGroup&, GroupWorkspace&, std::uint32_t mask) const;
  void sense(StateGroup&, const SkybodyLanes&, std::int64_t steps_left) const;
  void sense(StateGroup&, const SkybodyLanes&, const PluginInstance&) const;
  void finish_transition(StateGroup&, GroupWorkspace&, std::uint32_t mask, bool is_reset,
                         const Rows&) const;
  std::uint32_t finite_robot_rewards(const GroupWorkspace&, std::uint32_t mask) const;
  std::uint64_t bad_state_bits(const StateGroup& group, int lane) const;
  std::string reason_of_body(std::uint64_t status) const;
  void finish_faults(StateGroup&, GroupWorkspace&, std::uint32_t faults, std::uint32_t finite,
                     const Rows&) const;
  std::uint32_t write_observation(GroupWorkspace&, std::uint32_t mask, const Rows&) const;
  void write_images(const StateGroup&, std::uint32_t mask, const Rows&) const;
  void write_last_observation(const StateGroup&, std::uint32_t mask, const Rows&) const;
  std::uint32_t write_row(std::uint32_t mask, int lanes, const double* values, float* rows) const;
  void keep_observation(StateGroup&, const GroupWorkspace&, std::uint32_t mask) const;
  void gather_observation(const StateGroup&, GroupWorkspace&) const;
  void write_agent_rewards(GroupWorkspace&, std::uint32_t mask, const Rows&) const;
  void evaluate(StateGroup&, GroupWorkspace&, const SkybodyLanes&, bool wants_info) const;
  void check(const StateGroup&, const GroupWorkspace&, std::uint32_t mask) const;
  void place_at_start(StateGroup&, int lane) const;
  void start(StateGroup&, std::uint32_t mask) const;
  void draw(StateGroup&, const SkybodyLanes&, SkybodyOccasion) const;
  void draw_in_time(StateGroup&, GroupWorkspace&, const SkybodyLanes&) const;
  void draw_with_requests(StateGroup&, const GroupWorkspace&, const SkybodyLanes&,
                          int repetition) const;
  void draw_start(StateGroup&, GroupWorkspace&, std::uint32_t mask) const;
  void draw_task(StateGroup&, GroupWorkspace&, std::uint32_t mask) const;
  void draw_again(StateGroup&, GroupWorkspace&, int lane) const;
  void keep_undrawn(const StateGroup&, GroupWorkspace&) const;
  void put_back_undrawn(StateGroup&, const GroupWorkspace&, int lane) const;
  std::optional<StartOverlap> find_overlap(StateGroup&, GroupWorkspace&, int lane) const;
  void look_for_bad_starts();
  bool draws_bodies() const;
  void clear_plugin_states(StateGroup&, std::uint32_t mask) const;
  void reset_plugin(const PluginInstance&, StateGroup&, GroupWorkspace&, std::uint32_t mask) const;
  const std::uint64_t* number_requests(StateGroup&, GroupWorkspace&, std::uint32_t mask) const;
  void silence_rotors(StateGroup&, std::uint32_t mask) const;
  void settle_joint_drives(StateGroup&, std::uint32_t mask) const;
  void hold_to_bounds(StateGroup&, std::uint32_t mask, int param) const;
  void remember_bodies(StateGroup&, std::uint32_t mask) const;
  /// Whether a plugin reads contacts.
  bool senses_contacts() const { return needs_contacts_ || !contact_pairs_.empty(); }
  void find_contacts(StateGroup&, GroupWorkspace&, int lane) const;
  void add_up_bodies(StateGroup&, const std::vector<Contact>&, int lane) const;
  void add_up_pairs(StateGroup&, const std::vector<Contact>&, int lane) const;
  void sense_joint_reactions(StateGroup&, GroupWorkspace&, std::uint32_t mask) const;
  void sense_contacts(StateGroup&, GroupWorkspace&, std::uint32_t mask) const;
  void write_reports(const StateGroup&, GroupWorkspace&) const;
  SkybodyLanes view(const StateGroup&, GroupWorkspace&, std::uint32_t mask) const;

  std::unique_ptr<const World> world_;
  std::unique_ptr<const GroupPhysics> physics_;
  std::array<std::vector<PluginInstance>, SKYBODY_KIND_COUNT> plugins_;
  std::vector<ControllerChain> chains_;
  std::vector<ActionChannel> action_channels_;
  std::vector<Channel> info_channels_;
  std::vector<int> info_params_;  ///< EnvParams that are reported as the last infos
  bool is_checked_ = false;
  bool needs_bodies_before_ = false;
  bool needs_contacts_ = false;
  bool draws_in_time_ = false;  ///< whether a randomizer draws during an episode
  bool draws_bodies_ = false;   ///< whether randomizers write mass properties of bodies
  InitialStates starts_;
  Block task_params_;                       ///< the task's own, within the parameter block
  std::vector<ContactPair> contact_pairs_;  ///< requested by plugins
  std::vector<int> joint_reactions_;        ///< bodies whose joint reactions plugins read
  int commanded_ = 0;                       ///< command values set by the action or the task
  int signal_size_ = 0;                     ///< size of the largest controller output
  int scratch_size_ = 0;                    ///< largest scratch requested by a plugin
  ObservationPlan plan_;
  std::size_t image_words_ = 0;  ///< for all sensors' images of one environment
  std::vector<int> agents_;
  std::unique_ptr<const StateValues> state_values_;
  std::unique_ptr<const StartOverlaps> start_overlaps_;  ///< null: starts are not checked
  std::vector<int> drawn_words_;  ///< state words that randomizers change and a reset keeps
  LaneState initial_;             ///< state at every reset before draws, with nominal parameters
};

}  // namespace skybody
