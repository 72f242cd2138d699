// A scenario as data: the contents of one environment. core/io reads it from YAML; plugins are only
// names here. C++17.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/model/picture.h"
#include "core/model/robot_model.h"
#include "core/model/source_location.h"

namespace skybody {

enum class ParameterType { kReal, kInteger, kBoolean, kText };

/// The value of a plugin's parameter in a scenario.
struct ParameterValue {
  std::string name;
  ParameterType type = ParameterType::kReal;
  std::vector<double> numbers;     ///< reals, integers and booleans (0, 1); one or more
  std::vector<std::string> texts;  ///< texts; one or more
  bool is_given = true;            ///< given in the scenario; else the default
  SourceLocation mark;
};

/// A plugin in a scenario, with validated parameters (defaults filled in).
struct PluginUse {
  std::string plugin;  ///< the plugin's own name
  std::string
      instance;  ///< its name in paths such as controllers.rate_pd.kp; unique per kind and robot
  SourceLocation mark;  ///< of the `plugin:` value
  std::vector<ParameterValue> parameters;
};

enum class DynamicsChoice { kAuto, kSimbody, kTree };
enum class IntegratorChoice { kMidpoint, kSemiImplicitEuler, kRk4, kCvode, kArkode };

/// Whether it chooses its own steps within dt, from an error estimate.
inline bool is_error_controlled(IntegratorChoice integrator) {
  return integrator == IntegratorChoice::kCvode || integrator == IntegratorChoice::kArkode;
}

/// Methods of `cvode` (the first two) and `arkode`.
enum class SolverMethod { kAdams, kBdf, kErk, kDirk };

/// Settings of an error-controlled integrator.
struct SolverSettings {
  SolverMethod method = SolverMethod::kAdams;
  double relative_tolerance = 1e-8;
  double absolute_tolerance = 1e-11;  ///< [m, rad, m/s, rad/s]
  int max_steps = 500;                ///< internal steps per physics step
};

/// The time grid and the integration method.
struct Stepping {
  double dt = 0.001;      ///< physics step [s]
  int action_repeat = 1;  ///< K, physics steps per action
  int horizon = 0;        ///< steps (actions) until truncation; 0: none
  DynamicsChoice dynamics = DynamicsChoice::kAuto;
  IntegratorChoice integrator = IntegratorChoice::kMidpoint;
  SolverSettings solver;         ///< of an error-controlled integrator
  SourceLocation dynamics_mark;  ///< of `dynamics`: some worlds do not support every choice
};

/// Contact law, in addition to the world's constants. The stiffness is derived from `penetration`
/// and the robots' masses.
struct ContactSettings {
  bool ground = true;  ///< the plane z = 0 of W supports robots
  double penetration =
      0.001;         ///< static penetration under the robot's own weight [m]; sets the stiffness
  int redraws = 16;  ///< largest number of repeated draws of a start in which robots overlap
                     ///< something; 0: starts are used as drawn
};

/// A fixed shape in the world.
struct Obstacle {
  std::string name;
  Shape shape;  ///< nominal; its pose is in W
  bool is_gate =
      false;  ///< a frame of four bars around a passage along x; `shape` is then a box whose size
              ///< is the opening's width (y) and height (z), and the bars' thickness
  SourceLocation mark = {};  ///< of the obstacle's entry
};

/// The collision shapes of an obstacle, in its own frame: its shape, or the bars of a gate.
std::vector<Shape> obstacle_shapes_of(const Obstacle& obstacle);

enum class CouplingKind {
  kRod,    ///< keeps its ends at a constant distance
  kRope,   ///< limits the distance of its ends to its length
  kPoint,  ///< keeps its ends at one point, as a ball joint does
  kSpring  ///< spring and damper along the line between its ends
};

/// An attachment point of a coupling.
struct CouplingEnd {
  int robot = -1;                     ///< -1: the world
  int body = 0;                       ///< index into the robot's bodies
  Vec3<double> point{0.0, 0.0, 0.0};  ///< in the body's frame, or in W [m]
};

/// A coupling of two bodies, of one robot or two, or of a body and the world.
struct Coupling {
  std::string name;
  CouplingKind kind = CouplingKind::kRod;
  std::array<CouplingEnd, 2> ends;
  std::array<double, kCouplingParamCount> constants =
      fallbacks<kCouplingParamCount>(kCouplingConstants);  ///< values of kCouplingConstants
  bool has_length = false;  ///< the length is given; else the initial distance is used
  SourceLocation mark;      ///< of its length, or of its entry
};

/// Number of kCouplingConstants that apply to a kind, counted from the first.
constexpr int coupling_constant_count(CouplingKind kind) {
  if (kind == CouplingKind::kPoint) return 1;
  return kind == CouplingKind::kSpring ? kCouplingParamCount : 2;
}

/// A sensor's channel that the scenario adds to the task's observation, or a column of the task
/// that it gives to the critic alone.
struct ObservedChannel {
  std::string channel;         ///< `sensor.channel`, or `task.column`
  std::string name;            ///< of its column; never empty
  bool privileged = false;     ///< for a critic only
  std::optional<double> low;   ///< least value; replaces the sensor's declared one
  std::optional<double> high;  ///< greatest value; likewise
  SourceLocation mark;
};

/// Randomizable values reported in the infos.
struct InfoUse {
  std::vector<std::string> paths;
  SourceLocation mark;
};

/// One robot of a scenario.
struct RobotUse {
  std::string name;
  RobotModel model;
  Pose pose;                 ///< of the base at reset [W]
  double rotor_speed = 0.0;  ///< of every rotor at reset [rad/s]; negative: hover speed
  std::array<double, kRobotParamCount> constants{};  ///< values of kRobotConstants
  std::vector<PluginUse> controllers;                ///< in order of evaluation
  SourceLocation mark;                               ///< of the robot's entry
};

/// A group of robots with shared controllers.
struct TeamUse {
  std::string name;
  std::vector<int> robots;             ///< indices, one or more, each once
  std::vector<PluginUse> controllers;  ///< in order of evaluation
};

/// The complete description of an environment.
struct Scenario {
  std::string name;
  std::string file;
  std::string text;        ///< the merged scenario as YAML, for logs; its hash identifies runs
  std::uint64_t hash = 0;  ///< over text, model files and plugin parameters
  Stepping stepping;
  std::array<double, kWorldParamCount> constants = fallbacks<kWorldParamCount>(kWorldConstants);
  ContactSettings contact;
  std::vector<RobotUse> robots;
  std::vector<TeamUse> teams;
  std::vector<Obstacle> obstacles;
  std::vector<Coupling> couplings;
  std::vector<PluginUse> sensors;
  std::vector<PluginUse> effects;
  std::vector<PluginUse> randomization;
  std::vector<ObservedChannel> observe;  ///< in the order of the observation
  InfoUse infos;
  PluginUse task;
  ReadPicture read_picture = nullptr;  ///< for textures

  /// Nominal [m/s^2], W axes.
  Vec3<double> gravity() const {
    return {constants[kGravity], constants[kGravity + 1], constants[kGravity + 2]};
  }
};

}  // namespace skybody
