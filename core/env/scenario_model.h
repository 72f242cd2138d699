// The immutable data of a compiled scenario: world, physics, configured plugins, and the places of
// all values. The phases of a transition (transition_phases.h) read it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/env/controller_chains.h"
#include "core/env/initial_states.h"
#include "core/env/observation_plan.h"
#include "core/env/plugin_instance.h"
#include "core/env/state_group.h"
#include "core/physics/world/lane_state.h"
#include "core/physics/world/world.h"

namespace skybody {

class GroupWorkspace;

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

/// Built once by build_scenario_model(), constant afterwards.
struct ScenarioModel {
  std::unique_ptr<const World> world;
  std::unique_ptr<const GroupPhysics> physics;
  /// Plugins in the order of the scenario; controllers in robot order.
  std::array<std::vector<PluginInstance>, SKYBODY_KIND_COUNT> plugins;
  std::vector<ControllerChain> chains;
  std::vector<ActionChannel> action_channels;  ///< in the order of the action row
  /// Values reported beside the observation: the task's, those of other plugins by instance, and
  /// the randomizable values named in the scenario.
  std::vector<Channel> info_channels;
  std::vector<int> info_params;  ///< EnvParams that are reported as the last infos
  ObservationPlan observation;
  std::vector<int> agents;  ///< robots that take actions, in order
  InitialStates starts;     ///< the robots' initial states, as EnvParams
  LaneState nominal;        ///< state at every reset before draws, with nominal parameters
  Block task_params;        ///< the task's own, within the parameter block
  std::vector<ContactPair> contact_pairs;  ///< requested by plugins
  std::vector<int> joint_reactions;        ///< bodies whose joint reactions plugins read
  std::vector<std::int32_t> offered;       ///< rows of plugin_state that sensors read from effects
  std::vector<int> drawn_words;  ///< state words that randomizers change and a reset keeps
  std::size_t image_words = 0;   ///< for all sensors' images of one environment
  int commanded = 0;             ///< command values set by the action or the task
  int signal_size = 0;           ///< size of the largest controller output
  int scratch_size = 0;          ///< largest scratch requested by a plugin, of each lane
  int scratch_block_size = 0;    ///< largest scratch block
  bool is_checked = false;
  bool needs_bodies_before = false;
  bool needs_contacts = false;

  const StateLayout& layout() const { return world->layout; }
  const Scenario& scenario() const { return world->scenario; }
  const PluginInstance& task() const { return plugins[SKYBODY_TASK][0]; }
  const std::vector<PluginInstance>& of(SkybodyKind kind) const { return plugins[kind]; }
  /// Whether a plugin reads contacts.
  bool senses_contacts() const { return needs_contacts || !contact_pairs.empty(); }
  /// Whether robots that begin inside something are drawn again.
  bool checks_starts() const;
  /// The command words of a robot: those of its chains, in order. Size 0: the robot takes no
  /// command.
  Block commands_of(int robot) const;

  /// The view that plugins get of the lanes in `mask`.
  SkybodyLanes view(const StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const;
  /// @param lanes  1 or kGroupLanes
  StateGroup make_state(int lanes) const;
  /// Scratch for groups of that size. Results never depend on the groups that used it before.
  std::unique_ptr<GroupWorkspace> make_workspace(int lanes) const;
};

/// The lanes in which a plugin with a period is called before or after this physics step.
std::uint32_t due(const PluginInstance& plugin, const StateGroup& group, std::uint32_t mask);

/// Whether a sensor is not called after this physics step, because it is due again before its
/// output is read. @param steps_left  as SensingPhase::sense_due
bool is_left_out(const PluginInstance& sensor, std::int64_t steps_left);

/// Configures the plugins and builds the world.
/// @param checking  kYes: checked mode. Groups have one lane, and calls throw LocatedError where a
///   plugin touches values that it may not touch
/// @throws LocatedError with the scenario's line if a plugin refuses its configuration or signals
///   do not match
std::unique_ptr<const ScenarioModel> build_scenario_model(Scenario scenario, PluginFactory& factory,
                                                          Checking checking);

}  // namespace skybody
