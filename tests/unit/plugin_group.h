// The values of a group of environments that a plugin's kernels read and write.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/plugin_abi/abi.h"

namespace skybody::testing {

/// What plugins read of the physics, in the layout of Group.
struct GroupPhysics {
  std::vector<double> bodies, before, q, u, rotor_speed, rotor_command;
  std::vector<double> contacts;                        ///< contacts of each body, as in ContactSum
  std::vector<double> contact_pairs, joint_reactions;  ///< in the order of the requests
  std::vector<double> sensors;  ///< outputs of other sensors, PluginWorld::add_sensor()
  std::vector<double> offered;  ///< values of effects, in the order of the requests
};

/// Values of a group of environments, scalar k of lane l at [k * lanes + l].
struct Group : GroupPhysics {
  int lanes = 1;
  std::vector<std::uint64_t> key, episode, step, physics_step, state, end;
  std::vector<double> params, action, command;
  std::vector<double> buffer, input, output, observation, reward, robot_reward, info;
  std::vector<double> memo, scratch;  ///< not part of the state: neither compared nor passed on

  std::array<std::vector<double>, SKYBODY_HELD_COUNT> held;  ///< empty: not declared

  double& at(std::vector<double>& block, int k, int lane = 0) const {
    return block[static_cast<std::size_t>(k * lanes + lane)];
  }
  /// One lane as a group of its own.
  Group alone(int lane) const {
    Group one;
    one.lanes = 1;
    one.memo.resize(memo.size() / static_cast<std::size_t>(lanes));
    one.scratch.resize(scratch.size() / static_cast<std::size_t>(lanes));
    each(*this, one, [&](const auto& from, auto& to) {
      to.clear();
      for (std::size_t k = static_cast<std::size_t>(lane); k < from.size();
           k += static_cast<std::size_t>(lanes)) {
        to.push_back(from[k]);
      }
    });
    return one;
  }
  template <class F>
  static void each(const Group& a, Group& b, F&& f) {
    f(a.key, b.key), f(a.episode, b.episode), f(a.step, b.step), f(a.state, b.state),
        f(a.end, b.end);
    f(a.physics_step, b.physics_step), f(a.bodies, b.bodies), f(a.before, b.before), f(a.q, b.q);
    f(a.u, b.u), f(a.rotor_speed, b.rotor_speed), f(a.params, b.params), f(a.action, b.action);
    f(a.rotor_command, b.rotor_command);
    f(a.command, b.command), f(a.buffer, b.buffer), f(a.input, b.input), f(a.output, b.output);
    f(a.observation, b.observation), f(a.reward, b.reward);
    f(a.robot_reward, b.robot_reward), f(a.info, b.info), f(a.contacts, b.contacts);
    f(a.contact_pairs, b.contact_pairs), f(a.joint_reactions, b.joint_reactions);
    f(a.sensors, b.sensors), f(a.offered, b.offered);
    for (std::size_t i = 0; i < a.held.size(); ++i) f(a.held[i], b.held[i]);
  }
  /// Copies memory that the host does not keep; inactive lanes may be overwritten in it.
  void take_scratch(const Group& other, bool with_output) {
    observation = other.observation;
    reward = other.reward;
    robot_reward = other.robot_reward;
    info = other.info;
    if (with_output) output = other.output;
  }
  /// All NaNs count as one value, as in the trajectory hash.
  bool same_bits(const Group& other) const {
    bool same = lanes == other.lanes;
    Group copy = other;
    each(*this, copy, [&](const auto& a, auto& b) {
      same = same && std::equal(a.begin(), a.end(), b.begin(), b.end(), [](auto x, auto y) {
               return std::memcmp(&x, &y, sizeof(x)) == 0 || (x != x && y != y);
             });
    });
    return same;
  }
};

}  // namespace skybody::testing
