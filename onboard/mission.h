// A mission: all that a vehicle needs to fly a policy, in one file without YAML and HDF5.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/files/policy_file.h"
#include "onboard/setup_copy.h"

namespace skybody::onboard {

/// A column of the policy's observation, for tables.
struct Column {
  std::string name, unit, doc;
  std::int32_t first = 0, count = 0;  ///< values of the row

  template <class Archive>
  void visit(Archive& a) {
    a(name, unit, doc, first, count);
  }
};

/// A run of values of a row, copied from the task's values or from the sensors' outputs.
struct Part {
  bool is_of_task = false;
  std::int32_t from = 0, to = 0, count = 0;

  template <class Archive>
  void visit(Archive& a) {
    a(is_of_task, from, to, count);
  }
};

/// A part of the action, with the physical values of -1 and +1.
struct ActionRange {
  std::string name;  ///< of the signal
  std::int32_t robot = 0, first = 0;
  std::vector<double> low, high;

  template <class Archive>
  void visit(Archive& a) {
    a(name, robot, first, low, high);
  }
};

/// The command that replaces the policy's when something is wrong.
enum class SafeAction : std::uint8_t {
  kDescend,  ///< level, with a share of the hover thrust, for `safe_time`; then kStop
  kStop,     ///< commands of zero
};

/// Bounds of the flight. Beyond one of them the safe command is sent.
struct Limits {
  double stale = 0.2;      ///< greatest age of a pose [s]
  double lateness = 0.05;  ///< greatest delay of a step [s]
  double tilt = 1.4;       ///< greatest angle between the z axes of B and W [rad]
  std::array<double, 3> fence_low{-1e6, -1e6, -1e6},
      fence_high{1e6, 1e6, 1e6};  ///< position, W [m]
  SafeAction safe = SafeAction::kDescend;
  double safe_thrust = 0.9;  ///< of kDescend: share of the hover thrust
  double safe_time = 5.0;    ///< of kDescend [s]

  template <class Archive>
  void visit(Archive& a) {
    a(stale, lateness, tilt);
    for (double& value : fence_low) a(value);
    for (double& value : fence_high) a(value);
    a(safe, safe_thrust, safe_time);
  }
};
/// Sets a limit by its name, as of --limit: `fence` with six values, least and greatest x, y, z;
/// the others with one; `safe`: 0 stops, 1 descends. @throws Error for another name or number of
/// values
void set_limit(Limits& limits, const std::string& name, const std::vector<double>& values);

struct Mission {
  std::string scenario, scenario_hash;  ///< of the policy's training
  std::string task, task_version;       ///< the plugin that makes the observation
  std::int32_t robot = 0;               ///< index of the robot that is flown
  std::int32_t agent = 0;               ///< its place among those that share the policy
  std::uint64_t seed = 0;               ///< of the task's random numbers
  SetupCopy setup;
  std::vector<Column> columns;
  std::vector<Part> parts;
  bool is_task_in_place = true;  ///< the row begins with the task's values
  std::vector<ActionRange> actions;
  PolicyFile policy;
  Limits limits;

  double period() const { return setup.setup().dt * setup.setup().action_repeat; }  ///< [s]
  const SkybodyRobotInfo& vehicle() const {
    return setup.robots()[static_cast<std::size_t>(robot)];
  }
  /// The chain that takes the robot's command.
  const SkybodyChainInfo& chain() const;
  double mass() const;     ///< of the robot [kg]
  double gravity() const;  ///< magnitude [m/s^2]
  /// The nominal largest thrust of rotor k of the robot [N].
  double largest_thrust(int k) const;
  double largest_thrust() const;  ///< of all its rotors [N]

  template <class Archive>
  void visit(Archive& a);
};

/// The bytes of a mission file.
std::string to_bytes(Mission& mission);
/// @throws Error if they are no mission, damaged or of another version
Mission from_bytes(std::string_view bytes);

/// @throws Error with the file's name, as from_bytes(), and if it cannot be read
Mission read_mission(const std::filesystem::path& file);

/// Gates from a text file: one a line, `x y z yaw [width height]` in m and rad, W, in the order of
/// the race; empty lines and lines that begin with # do not count. @throws Error
std::vector<std::vector<double>> read_gates(const std::filesystem::path& file,
                                            const Mission& mission);

/// The content of a file. @throws Error
std::string read_file(const std::filesystem::path& file);

}  // namespace skybody::onboard
