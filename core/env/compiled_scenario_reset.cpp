// Begins an episode. Order:
//
// 1. the scenario's start
// 2. randomizers (compiled_scenario_draw.cpp)
// 3. contacts
// 4. reset() of controllers
// 5. joint reactions
// 6. reset() of task, effects and sensors
// 7. sense, evaluate, finish the transition
#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "core/env/compiled_scenario.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_call.h"

namespace skybody {

void CompiledScenario::initialize(StateGroup& group, int lane, std::uint64_t seed,
                                  std::uint64_t stream_env) const {
  group.clear(lane);
  group.writable(kSeed)[lane] = seed;
  group.writable(kEnvId)[lane] = stream_env;
  place_at_start(group, lane);
  group.scatter(lane, layout().params, initial_.params.data());
}

/// The scenario's poses, velocities, rotors, held commands and joint drives.
void CompiledScenario::place_at_start(StateGroup& group, int lane) const {
  const StateLayout& l = layout();
  group.scatter(lane, l.q, initial_.q.data());
  group.scatter(lane, l.u, initial_.u.data());
  group.scatter(lane, l.rotor_speed, initial_.rotor_speed.data());
  group.scatter(lane, l.rotor_command, initial_.rotor_command.data());
  group.scatter(lane, l.drive, initial_.drive.data());
  group.scatter(lane, l.joint_command, initial_.joint_command.data());
  group.scatter(lane, l.joint_state, initial_.joint_state.data());
  group.scatter(lane, l.coupling_forces, initial_.coupling_forces.data());
  group.scatter(lane, l.bristles, initial_.bristles.data());
}

void CompiledScenario::reset(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                             const Rows& rows) const {
  check(group, work, mask);
  work.clear_faults();
  start(group, mask);
  clear_plugin_states(group, mask);
  draw_start(group, work, mask);
  settle_joint_drives(group, mask);
  remember_bodies(group, mask);
  sense_contacts(group, work, mask);
  for (const PluginInstance& c : plugins_[SKYBODY_CONTROLLER]) reset_plugin(c, group, work, mask);
  silence_rotors(group, mask);  // after controllers have read the initial speeds
  update(group, work, mask);
  sense_joint_reactions(group, work, mask);
  for (const SkybodyKind kind : {SKYBODY_TASK, SKYBODY_EFFECT, SKYBODY_SENSOR}) {
    for (const PluginInstance& p : plugins_[kind]) reset_plugin(p, group, work, mask);
  }
  const SkybodyLanes lanes = view(group, work, mask);
  for (const PluginInstance& sensor : plugins_[SKYBODY_SENSOR]) sense(group, lanes, sensor);
  evaluate(group, work, lanes, rows.info != nullptr);
  finish_transition(group, work, mask, true, rows);
}

/// Sets counters, places robots by their EnvParams, and clears commands. Drawn parameters persist
/// until a randomizer is due.
void CompiledScenario::start(StateGroup& group, std::uint32_t mask) const {
  const StateLayout& l = layout();
  each_lane(mask, [&](int lane) {
    ++group.writable(kEpisode)[lane];
    group.writable(kStep)[lane] = 0;
    group.writable(kPhysicsStep)[lane] = 0;
    group.writable(kStatus)[lane] = kRunning;
    group.writable(kRedraws)[lane] = 0;
    place_at_start(group, lane);
    group.images().clear(lane);
    for (const Block& block :
         {l.wrench, l.bodies_before, l.action, l.command, l.sensors, l.contacts, l.contact_pairs,
          l.joint_reactions, l.last_observation}) {
      double* values = group.writable(block, mask);
      for (int k = 0; k < block.size; ++k) values[k * group.lanes() + lane] = 0.0;
    }
  });
  starts_.place(group, mask);
}

/// Sets all words of plugins to 0, except those of randomizers, and all held inputs to neutral.
void CompiledScenario::clear_plugin_states(StateGroup& group, std::uint32_t mask) const {
  for (int kind = 0; kind < SKYBODY_KIND_COUNT; ++kind) {
    if (kind == SKYBODY_RANDOMIZER) continue;
    for (const PluginInstance& p : plugins_[static_cast<std::size_t>(kind)]) {
      for (int k = p.state; k < p.state + p.state_words + p.buffer_words; ++k) {
        std::uint64_t* words = group.plugin_bits(k);
        each_lane(mask, [&](int lane) { words[lane] = 0; });
      }
      if (p.last_output.size == 0) continue;
      double* given = group.writable(p.last_output, mask);
      for (int k = 0; k < p.last_output.size; ++k, given += group.lanes()) {
        each_lane(mask, [&](int lane) { given[lane] = 0.0; });
      }
    }
  }
  clear_held(group, mask);
}

void CompiledScenario::reset_plugin(const PluginInstance& plugin, StateGroup& group,
                                    GroupWorkspace& work, std::uint32_t mask) const {
  if (plugin.kernels.reset == nullptr) return;
  const SkybodyLanes v = view(group, work, mask);
  call_plugin(plugin.kernels.reset, plugin, group, v, no_sizes);
}

/// Stops the rotors of robots that a wrench or a drive moves instead: otherwise rotors that run
/// down would push them as well.
void CompiledScenario::silence_rotors(StateGroup& group, std::uint32_t mask) const {
  for (int r = 0; r < static_cast<int>(scenario().robots.size()); ++r) {
    bool is_moved = false, has_live_rotors = false;
    for (const ControllerChain& chain : chains_) {
      for (const ChainEnd& end : chain.ends) {
        if (end.robot != r || end.block == &StateLayout::command) continue;
        has_live_rotors |= end.signal == SKYBODY_ROTOR_SPEED;
        is_moved |= end.signal != SKYBODY_ROTOR_SPEED && end.signal != SKYBODY_JOINT;
      }
    }
    if (!is_moved || has_live_rotors) continue;
    const RobotLayout& robot = layout().robots[static_cast<std::size_t>(r)];
    for (int k = robot.first_rotor; k < robot.first_rotor + robot.rotor_count; ++k) {
      double* speed = group.writable({layout().rotor_speed.offset + k, 1}, mask);
      double* command = group.writable({layout().rotor_command.offset + k, 1}, mask);
      each_lane(mask, [&](int lane) { speed[lane] = command[lane] = 0.0; });
    }
  }
}

/// Position drives begin at the joints' positions, drawn or not.
void CompiledScenario::settle_joint_drives(StateGroup& group, std::uint32_t mask) const {
  const StateLayout& l = layout();
  for (std::size_t i = 0; i < world_->joint_drives.size(); ++i) {
    const JointDrive& drive = world_->joint_drives[i];
    if (drive.mode != JointMode::kPosition) continue;
    const int k = static_cast<int>(i);
    const WorldBody& body = world_->bodies[static_cast<std::size_t>(drive.body)];
    const double* q = group.reals(l.q.offset + body.q + drive.coordinate);
    double* command = group.writable({l.joint_command.offset + k, 1}, mask);
    double* state = group.writable({l.joint_state.offset + k, 1}, mask);
    each_lane(mask, [&](int lane) { command[lane] = state[lane] = q[lane]; });
  }
}

}  // namespace skybody
