// The layout of an environment's values: the only place that defines the order of state words.
//
// Scalar k of lane l of a group of L lanes is at data[k * L + l]. All values are 64-bit words:
// doubles, or std::uint64_t in the header and in plugin states.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/held_inputs.h"
#include "core/model/scenario.h"

namespace skybody {

/// Consecutive state words.
struct Block {
  int offset = 0;  ///< first word
  int size = 0;    ///< number of words
};

/// Positions of the header's words (each a std::uint64_t).
enum HeaderWord : int {
  kSeed = 0,         ///< first half of the random key
  kEnvId = 1,        ///< second half: the env id, or a fork's own key
  kEpisode = 2,      ///< number of resets so far
  kStep = 3,         ///< actions taken in this episode
  kPhysicsStep = 4,  ///< physics steps taken in this episode
  kForks = 5,        ///< number of rekeyed copies made of this environment
  kStatus = 6,       ///< EpisodeStatus bits of the last transition
  kRequests = 7,     ///< number of draws requested during episodes, in total
  kRedraws = 8,      ///< number of repeated draws of this episode's start
  kHeaderSize = 9,
};

/// Bits of kStatus, and of a transition's flags.
enum EpisodeStatus : std::uint64_t {
  kRunning = 0,
  kTerminated = 1,  ///< the task ended the episode
  kTruncated = 2,   ///< by the horizon, the task, or a fault
  kFault = 4,       ///< with one of the reasons below; always truncated as well
  kBadAction = 8,   ///< the action was not finite; the previous one was kept
  kBadState = 16,   ///< the physics failed, the state is not finite, or an inertia is not physical:
                    ///< then the bits from kBadStartPlace on are the world body index + 1, else
                    ///< they encode the likely cause (core/env/fault_cause.h)
  kBadOutcome = 32,  ///< observation or reward is not finite as a float
  kBadStart = 64,    ///< a robot overlaps something at its start, after all redraws; the bits from
                     ///< kBadStartPlace on give details (core/env/start_overlaps.h)
};
/// The first status bit with details of a bad start or state.
inline constexpr int kBadStartPlace = 7;

/// Positions of one robot's values in the q, u, rotor and body blocks.
struct RobotLayout {
  int first_body = 0, body_count = 0;
  int first_q = 0, q_count = 0;
  int first_u = 0, u_count = 0;
  int first_rotor = 0, rotor_count = 0;
};

/// A randomizable value: one word per environment in the parameter block.
struct EnvParam {
  std::string path;  ///< canonical, such as robots.quad.rotors[2].thrust_constant
  std::string unit;
  double nominal = 0.0;
  double min = 0.0;  ///< inclusive bounds of drawn values
  double max = 0.0;
  std::string alias = {};  ///< the path with a rotor's name or a joint's index; may be empty
};

/// The order of state words. Blocks follow each other in the order of the members.
struct StateLayout {
  Block header;         ///< kHeaderSize words
  Block q, u;           ///< coordinates of all robots, in body order
  Block rotor_speed;    ///< [rad/s], >= 0, every rotor of every robot
  Block rotor_command;  ///< the reference held during the physics step [rad/s]
  Block wrench;         ///< 6 per wrench site (force, moment), held during the physics step
  Block drive;          ///< 13 per driven robot: v, w (6), then pose (7); see core/plugin_abi/abi.h
  Block joint_command;  ///< 1 per joint drive, held during the physics step
  Block joint_state;    ///< 1 per joint drive: the command after its lag
  Block coupling_forces;  ///< 3 per coupling: its force on the first end, W [N]
  Block bristles;         ///< 3 per bristle of friction [m], W
                          ///< (core/physics/contact/normal_and_friction_law.h)
  std::array<Block, SKYBODY_HELD_COUNT> held;  ///< held_inputs.h; size 0: not used
  Block bodies_before;  ///< 13 per body at the start of the last physics step; size 0 if not
                        ///< requested
  Block params;         ///< EnvParams: every randomizable value
  Block action;         ///< last action, clipped to [-1, 1]
  Block command;        ///< inputs of all controller chains (core/env/controller_chains.h)
  Block sensors;        ///< outputs of all sensors
  Block contacts;  ///< 7 per body: its contacts (core/plugin_abi/abi.h); size 0 if not requested
  Block contact_pairs;     ///< 7 per pair requested by plugins (core/plugin_abi/abi.h)
  Block joint_reactions;   ///< 6 per joint requested by plugins
  Block plugin_state;      ///< words of all plugin instances
  Block last_observation;  ///< float values of the last finite observation, as doubles
  int words = 0;           ///< total
  int memo = 0;            ///< number of plugin values stored outside the state

  std::vector<RobotLayout> robots;
  std::vector<EnvParam> param_info;  ///< one per word of `params`
  int physics_params = 0;            ///< number of physical constants, which come first
  int world_params = 0;              ///< first of the kWorldParamCount words
  std::vector<int> robot_params;     ///< per robot: first of its kRobotParamCount words
  std::vector<int> body_params;      ///< per body: first of its kBodyParamCount words
  std::vector<int> joint_params;  ///< per body: first of its joint's joint_constant_count() words
  std::vector<int> rotor_params;  ///< per rotor: first of its kRotorParamCount words
  std::vector<int> coupling_params;  ///< per coupling: first of its coupling_constant_count() words
  std::vector<int> obstacle_params;  ///< per obstacle: first of its words, at most
                                     ///< kObstacleParamCount

  /// Index of the parameter with this path or alias, or -1.
  int find_param(const std::string& path) const;
  /// The parameter block of an environment without drawn values.
  std::vector<double> nominal_params() const;
};

}  // namespace skybody
