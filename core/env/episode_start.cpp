#include "core/env/episode_start.h"

#include "core/base/simd/lane_mask.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_call.h"

namespace skybody {

void EpisodeStart::initialize(StateGroup& group, int lane, std::uint64_t seed,
                              std::uint64_t stream_env) const {
  group.clear(lane);
  group.writable(kSeed)[lane] = seed;
  group.writable(kEnvId)[lane] = stream_env;
  place(group, lane);
  group.scatter(lane, model_.layout().params, model_.nominal.params.data());
}

void EpisodeStart::place(StateGroup& group, int lane) const {
  const StateLayout& l = model_.layout();
  group.scatter(lane, l.q, model_.nominal.q.data());
  group.scatter(lane, l.u, model_.nominal.u.data());
  group.scatter(lane, l.rotor_speed, model_.nominal.rotor_speed.data());
  group.scatter(lane, l.rotor_command, model_.nominal.rotor_command.data());
  group.scatter(lane, l.drive, model_.nominal.drive.data());
  group.scatter(lane, l.joint_command, model_.nominal.joint_command.data());
  group.scatter(lane, l.joint_state, model_.nominal.joint_state.data());
  group.scatter(lane, l.coupling_forces, model_.nominal.coupling_forces.data());
  group.scatter(lane, l.bristles, model_.nominal.bristles.data());
}

void EpisodeStart::begin(StateGroup& group, std::uint32_t mask) const {
  const StateLayout& l = model_.layout();
  each_lane(mask, [&](int lane) {
    ++group.writable(kEpisode)[lane];
    group.writable(kStep)[lane] = 0;
    group.writable(kPhysicsStep)[lane] = 0;
    group.writable(kStatus)[lane] = kRunning;
    group.writable(kRedraws)[lane] = 0;
    place(group, lane);
    group.images().clear(lane);
    group.take_undrawn(1u << lane);
    for (const Block& block :
         {l.wrench, l.bodies_before, l.action, l.command, l.sensors, l.contacts, l.contact_pairs,
          l.joint_reactions, l.last_observation}) {
      double* values = group.writable(block, mask);
      for (int k = 0; k < block.size; ++k) values[k * group.lanes() + lane] = 0.0;
    }
  });
  model_.starts.place(group, mask);
  clear_plugin_states(group, mask);
}

/// Sets all words of plugins to 0, except those of randomizers, and all held inputs to neutral.
void EpisodeStart::clear_plugin_states(StateGroup& group, std::uint32_t mask) const {
  for (int kind = 0; kind < SKYBODY_KIND_COUNT; ++kind) {
    if (kind == SKYBODY_RANDOMIZER) continue;
    for (const PluginInstance& p : model_.plugins[static_cast<std::size_t>(kind)]) {
      for (int k = p.memory.state;
           k < p.memory.state + p.memory.state_words + p.memory.buffer_words; ++k) {
        std::uint64_t* words = group.plugin_bits(k);
        each_lane(mask, [&](int lane) { words[lane] = 0; });
      }
      if (p.controller.last_output.size == 0) continue;
      double* given = group.writable(p.controller.last_output, mask);
      for (int k = 0; k < p.controller.last_output.size; ++k, given += group.lanes()) {
        each_lane(mask, [&](int lane) { given[lane] = 0.0; });
      }
    }
  }
  effects_.clear(group, mask);
}

void EpisodeStart::settle_joint_drives(StateGroup& group, std::uint32_t mask) const {
  const StateLayout& l = model_.layout();
  for (std::size_t i = 0; i < model_.world->joint_drives.size(); ++i) {
    const JointDrive& drive = model_.world->joint_drives[i];
    if (drive.mode != JointMode::kPosition) continue;
    const int k = static_cast<int>(i);
    const WorldBody& body = model_.world->bodies[static_cast<std::size_t>(drive.body)];
    const double* q = group.reals(l.q.offset + body.q + drive.coordinate);
    double* command = group.writable({l.joint_command.offset + k, 1}, mask);
    double* state = group.writable({l.joint_state.offset + k, 1}, mask);
    each_lane(mask, [&](int lane) { command[lane] = state[lane] = q[lane]; });
  }
}

void EpisodeStart::silence_rotors(StateGroup& group, std::uint32_t mask) const {
  for (int r = 0; r < static_cast<int>(model_.scenario().robots.size()); ++r) {
    bool is_moved = false, has_live_rotors = false;
    for (const ControllerChain& chain : model_.chains) {
      for (const ChainEnd& end : chain.ends) {
        if (end.robot != r || end.block == &StateLayout::command) continue;
        has_live_rotors |= end.signal == SKYBODY_ROTOR_SPEED;
        is_moved |= end.signal != SKYBODY_ROTOR_SPEED && end.signal != SKYBODY_JOINT;
      }
    }
    if (!is_moved || has_live_rotors) continue;
    const RobotLayout& robot = model_.layout().robots[static_cast<std::size_t>(r)];
    for (int k = robot.first_rotor; k < robot.first_rotor + robot.rotor_count; ++k) {
      double* speed = group.writable({model_.layout().rotor_speed.offset + k, 1}, mask);
      double* command = group.writable({model_.layout().rotor_command.offset + k, 1}, mask);
      each_lane(mask, [&](int lane) { speed[lane] = command[lane] = 0.0; });
    }
  }
}

void EpisodeStart::reset_plugins(SkybodyKind kind, StateGroup& group, GroupWorkspace& work,
                                 std::uint32_t mask) const {
  for (const PluginInstance& plugin : model_.of(kind)) {
    if (plugin.kernels.reset == nullptr) continue;
    const SkybodyLanes view = model_.view(group, work, mask);
    call_plugin(plugin.kernels.reset, plugin, group, view, no_sizes);
  }
}

}  // namespace skybody
