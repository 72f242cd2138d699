// A scenario as data: what one environment consists of. Made by core/io from YAML; names of plugins
// are only words here. C++17.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/model/robot_model.h"

namespace skybody {

/// Where a value was written: file and position, or "--set path=value" with line 0.
struct SourceLocation {
  std::string file;
  int line = 0;    ///< from 1; 0: not from a file
  int column = 0;  ///< from 1
};

enum class ParameterType { kReal, kInteger, kBoolean, kText };

/// One value of a plugin's parameter as the scenario gives it.
struct ParameterValue {
  std::string name;
  ParameterType type = ParameterType::kReal;
  std::vector<double> numbers;     ///< reals, integers and booleans (0, 1); one or more
  std::vector<std::string> texts;  ///< texts; one or more
  bool is_given = true;            ///< the scenario says so, else it is the default
  SourceLocation mark;
};

/// A plugin as a scenario names it, with validated parameters (defaults filled in).
struct PluginUse {
  std::string plugin;  ///< the plugin's own name
  std::string
      instance;  ///< its name in paths such as controllers.rate_pd.kp; unique per kind and robot
  SourceLocation mark;  ///< of the `plugin:` value
  std::vector<ParameterValue> parameters;
};

enum class DynamicsChoice { kAuto, kSimbody, kTree };
enum class IntegratorChoice { kMidpoint, kSemiImplicitEuler, kRk4, kCvode, kArkode };

/// Whether it chooses its own steps within dt, by an estimate of its error.
inline bool is_error_controlled(IntegratorChoice integrator) {
  return integrator == IntegratorChoice::kCvode || integrator == IntegratorChoice::kArkode;
}

/// Methods of `cvode` (the first two) and `arkode`.
enum class SolverMethod { kAdams, kBdf, kErk, kDirk };

/// How an error-controlled integrator works.
struct SolverSettings {
  SolverMethod method = SolverMethod::kAdams;
  double relative_tolerance = 1e-8;
  double absolute_tolerance = 1e-11;  ///< [m, rad, m/s, rad/s]
  int max_steps = 500;                ///< its own steps in one physics step
};

/// The time grid and how it is advanced.
struct Stepping {
  double dt = 0.001;      ///< physics step [s]
  int action_repeat = 1;  ///< K, physics steps an action
  int horizon = 0;        ///< steps (actions) until truncation; 0: none
  DynamicsChoice dynamics = DynamicsChoice::kAuto;
  IntegratorChoice integrator = IntegratorChoice::kMidpoint;
  SolverSettings solver;         ///< of an error-controlled integrator
  SourceLocation dynamics_mark;  ///< of `dynamics`: not every world can have every choice
};

/// Contact law, beside the world's constants. Stiffness is not given: it follows from `penetration`
/// and the robots' masses.
struct ContactSettings {
  bool ground = true;  ///< the plane z = 0 of W carries robots
  double penetration =
      0.001;  ///< static penetration under the robot's own weight [m]; fixes stiffness by mass
  int redraws = 16;  ///< how often a drawn start is drawn again where robots begin inside
                     ///< something; 0: starts are taken as they are drawn
};

/// A shape that stands in the world.
struct Obstacle {
  std::string name;
  Shape shape;  ///< nominal; its pose is in W
  bool is_gate =
      false;  ///< a frame of four bars about a way through along x; a box whose size is
              ///< width and height of the opening, along y and z, and the bars' thickness
  SourceLocation mark = {};  ///< of the whole
};

/// The solids of an obstacle, in its own frame: itself, or the bars of a gate.
std::vector<Shape> obstacle_shapes_of(const Obstacle& obstacle);

enum class CouplingKind {
  kRod,    ///< keeps its ends at a distance
  kRope,   ///< lets its ends get no farther apart than its length
  kPoint,  ///< keeps its ends at one place, as a ball joint does
  kSpring  ///< pulls and pushes along the line between its ends
};

/// What a coupling holds on to.
struct CouplingEnd {
  int robot = -1;                     ///< -1: the world
  int body = 0;                       ///< index into the robot's bodies
  Vec3<double> point{0.0, 0.0, 0.0};  ///< in the body's frame, or in W [m]
};

/// What joins two bodies, of one robot or two, or a body and the world.
struct Coupling {
  std::string name;
  CouplingKind kind = CouplingKind::kRod;
  std::array<CouplingEnd, 2> ends;
  std::array<double, kCouplingParamCount> constants =
      fallbacks<kCouplingParamCount>(kCouplingConstants);  ///< values of kCouplingConstants
  bool has_length = false;  ///< the length is given; else it is what the start has
  SourceLocation mark;      ///< of its length, or of the whole
};

/// How many of kCouplingConstants, from the first on, apply to a kind.
constexpr int coupling_constant_count(CouplingKind kind) {
  if (kind == CouplingKind::kPoint) return 1;
  return kind == CouplingKind::kSpring ? kCouplingParamCount : 2;
}

/// A sensor's channel that the scenario adds to the task's observation.
struct ObservedChannel {
  std::string channel;        ///< `sensor.channel`
  std::string name;           ///< of its column; never empty
  bool privileged = false;    ///< for a critic only
  std::optional<double> low;  ///< least value, in place of what the sensor declares
  std::optional<double> high;
  SourceLocation mark;
};

/// Randomizable values that join the infos.
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
  std::vector<PluginUse> controllers;                ///< in the order in which they are evaluated
  SourceLocation mark;                               ///< of the whole
};

/// Robots that controllers serve together.
struct TeamUse {
  std::string name;
  std::vector<int> robots;             ///< indices, one or more, each once
  std::vector<PluginUse> controllers;  ///< in the order in which they are evaluated
};

/// Everything that an environment is made from.
struct Scenario {
  std::string name;
  std::string file;
  std::string text;  ///< the fully merged scenario as YAML, for logs; its hash identifies runs
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

  /// Nominal [m/s^2], W axes.
  Vec3<double> gravity() const {
    return {constants[kGravity], constants[kGravity + 1], constants[kGravity + 2]};
  }
};

}  // namespace skybody
