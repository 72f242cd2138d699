#include "app/commands/check_flight.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/commands/check_light_links.h"
#include "app/commands/check_stiff_joints.h"
#include "app/report/rounded.h"
#include "core/base/math/math.h"
#include "core/base/math/random.h"
#include "core/env/error_location.h"
#include "core/env/start_overlaps.h"
#include "core/io/files/text.h"
#include "core/model/fault_reason.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/shapes/overlap.h"
#include "core/physics/world/pose_math.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

/// Steps: enough to reach every phase of a plugin whose period is at most this many actions.
constexpr int kSteps = 8;

/// Number of drawn starts that are checked for immediate failure.
constexpr int kStarts = 32;

/// A collision shape in its pose at the start of an episode.
struct PlacedShape {
  const Shape* shape;
  Pose pose;            ///< of its frame, W
  std::string whose;    ///< such as "robot `quad`"
  SourceLocation mark;  ///< of the robot in the scenario
};

/// Penetration depth between two shapes at the start.
struct Overlap {
  double depth = 0.0;   ///< [m]
  SourceLocation mark;  ///< of the robot
};

std::vector<PlacedShape> shapes_of_robots(const CompiledScenario& compiled,
                                          const std::vector<BodyState>& bodies) {
  const World& world = compiled.world();
  std::vector<PlacedShape> placed;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto index = static_cast<std::size_t>(world.bodies[i].robot);
    const RobotUse& robot = compiled.scenario().robots[index];
    for (const Shape& shape : world.bodies[i].model->collisions) {
      placed.push_back({&shape, compose({bodies[i].position, bodies[i].rotation}, shape.pose),
                        "robot `" + robot.name + "`", robot.mark});
    }
  }
  return placed;
}

/// Depth of the lowest point of a shape below the plane z = 0 [m].
double depth_in_ground(const PlacedShape& placed) {
  double depth = 0.0;
  for (const Vec3<double>& point : points_of(*placed.shape)) {
    depth = max(depth, -(placed.pose.position + rotate(placed.pose.rotation, point)).z);
  }
  return depth;
}

/// Overlaps at the start, by text such as "robot `a` begins inside robot `b`".
std::map<std::string, Overlap> find_overlaps(const CompiledScenario& compiled,
                                             const std::vector<PlacedShape>& robots) {
  std::map<std::string, Overlap> overlaps;
  const auto note = [&](const PlacedShape& robot, const std::string& other, double depth) {
    Overlap& overlap = overlaps[robot.whose + " begins inside " + other];
    overlap = {max(overlap.depth, depth), robot.mark};
  };
  for (auto a = robots.begin(); a != robots.end(); ++a) {
    if (compiled.scenario().contact.ground) note(*a, "the ground", depth_in_ground(*a));
    for (const Obstacle& obstacle : compiled.scenario().obstacles) {
      double depth = 0.0;
      for (const Shape& solid : obstacle_shapes_of(obstacle)) {
        depth = max(depth,
                    overlap(*a->shape, a->pose, solid, compose(obstacle.shape.pose, solid.pose)));
      }
      note(*a, "the obstacle `" + obstacle.name + "`", depth);
    }
    for (auto b = a + 1; b != robots.end(); ++b) {
      if (a->whose == b->whose) continue;
      note(*a, b->whose, overlap(*a->shape, a->pose, *b->shape, b->pose));
    }
  }
  return overlaps;
}

/// Warns of overlaps: contact separates overlapping shapes with large forces.
/// @param bodies  their states, with obstacles in their nominal places
void warn_of_overlaps(const CompiledScenario& compiled, const std::vector<BodyState>& bodies,
                      Diagnostics& diagnostics) {
  const double deep = kDeepStart * compiled.scenario().contact.penetration;
  for (const auto& [what, overlap] : find_overlaps(compiled, shapes_of_robots(compiled, bodies))) {
    if (overlap.depth < deep) continue;
    diagnostics.warning(overlap.mark,
                        what + ", by " + rounded(overlap.depth) + " m; move its `pose`");
  }
}

std::vector<float> random_action(int size, std::uint64_t step) {
  Random<double> random(RandomKey{0, 0}, 0, step, derive_stream("check.action"));
  std::vector<float> action(static_cast<std::size_t>(size));
  for (float& a : action) a = static_cast<float>(random.uniform(-1.0, 1.0));
  return action;
}

/// Line of the scenario whose randomizer writes the mass properties of a rigid body; no line if
/// there is none.
SourceLocation mark_of_drawn_body(const CompiledScenario& compiled, int body) {
  const StateLayout& layout = compiled.layout();
  const int first = layout.body_params[static_cast<std::size_t>(body)];
  const std::vector<PluginInstance>& randomizers = compiled.plugins(SKYBODY_RANDOMIZER);
  for (std::size_t i = 0; i < randomizers.size(); ++i) {
    for (const int param : randomizers[i].writes) {
      if (param < first || param >= first + kBodyParamCount) continue;
      return mark_of_writer(compiled.scenario(), compiled.scenario().randomization[i],
                            layout.param_info[static_cast<std::size_t>(param)]);
    }
  }
  return {compiled.scenario().file, 0, 0};
}

/// Reports faults in the trial flight. If bodies are not physical in all draws of several resets,
/// the scenario is wrong; other faults may be caused by the actions.
/// @param faults  of kSteps; @param status  of the last of them
void tell_of_faults(const CompiledScenario& compiled, int faults, std::uint64_t status,
                    Diagnostics& diagnostics) {
  if (faults == 0) return;
  const std::string reason = compiled.fault_reason(status);
  const int body = impossible_body(status);
  if (faults == kSteps && body >= 0) {
    diagnostics.error(mark_of_drawn_body(compiled, body),
                      "all draws of a trial flight give a body that cannot be: " + reason);
    return;
  }
  const std::string which = faults == kSteps
                                ? "every step of a trial flight ends in a fault"
                                : std::to_string(faults) + " of " + std::to_string(kSteps) +
                                      " steps of a trial flight end in a fault";
  diagnostics.warning({compiled.scenario().file, 0, 0}, which + ": " + reason);
}

/// Location of a plugin's parameter in the user's own file; none if it comes from an included file.
std::optional<SourceLocation> own_parameter(const Scenario& scenario, const PluginUse& use) {
  for (const ParameterValue& value : use.parameters) {
    if (value.is_given && is_own(scenario, value.mark)) return value.mark;
  }
  return std::nullopt;
}

/// The randomizer that writes the starts of robots, or null.
const PluginUse* drawer_of_starts(const CompiledScenario& compiled) {
  const std::vector<PluginInstance>& randomizers = compiled.plugins(SKYBODY_RANDOMIZER);
  for (std::size_t i = 0; i < randomizers.size(); ++i) {
    for (const int param : randomizers[i].writes) {
      const std::string& path = compiled.layout().param_info[static_cast<std::size_t>(param)].path;
      if (path.find(".start.position[") == path.npos) continue;
      return &compiled.scenario().randomization[i];
    }
  }
  return nullptr;
}

/// Location to report for a bad start: the user's entry for the draw of starts, the robot or the
/// task, in this order; otherwise the entry in an included file.
SourceLocation mark_of_starts(const CompiledScenario& compiled) {
  const Scenario& scenario = compiled.scenario();
  const PluginUse* drawer = drawer_of_starts(compiled);
  if (drawer != nullptr) {
    if (const auto own = own_parameter(scenario, *drawer)) return *own;
  }
  const RobotUse& first = scenario.robots[0];
  if (scenario.robots.size() == 1 && is_own(scenario, first.mark)) return first.mark;
  if (const auto own = own_parameter(scenario, scenario.task)) return *own;
  if (drawer != nullptr) return drawer->mark;
  return scenario.robots.size() == 1 ? first.mark : scenario.task.mark;
}

/// The failure that the task reports now, with its meaning; empty: none.
std::string present_failure(const Simulation& simulation) {
  std::size_t first = 0;
  for (const Channel& info : simulation.compiled().info_channels()) {
    const bool is_failure = info.name.rfind("failed.", 0) == 0;
    if (is_failure && simulation.info()[first] > 0.0f) {
      return "`" + info.name + "`" + (info.doc.empty() ? "" : " (" + info.doc + ")");
    }
    first += static_cast<std::size_t>(info.count);
  }
  return "";
}

/// Positions of robots: "robot `quad` at [0, 0, 1] m"; if there are many, only the first ones.
std::string places_text(const Simulation& simulation) {
  constexpr std::size_t kMost = 3;
  std::string text;
  const auto& robots = simulation.scenario().robots;
  for (std::size_t i = 0; i < robots.size() && i < kMost; ++i) {
    const Vec3<double>& p = simulation.base(robots[i].name).position;
    text += (i == 0 ? "" : ", ") + ("robot `" + robots[i].name) + "` at [" + rounded(p.x) + ", " +
            rounded(p.y) + ", " + rounded(p.z) + "] m";
  }
  return text + (robots.size() > kMost ? ", ..." : "");
}

/// The height of the lowest goal [m]; infinite without goals.
double lowest_goal(const Simulation& simulation) {
  double lowest = kInfinity;
  const std::vector<double> goals = simulation.goals();
  for (std::size_t k = 2; k < goals.size(); k += 4) lowest = min(lowest, goals[k]);
  return lowest;
}

/// Reports a problem of drawn starts: an error if all have it, otherwise a warning.
void tell_of_starts(const SourceLocation& mark, int wrong, int all, const std::string& what,
                    const std::string& more, Diagnostics& diagnostics) {
  if (wrong == 0) return;
  if (wrong == all) {
    diagnostics.error(mark, "every episode begins " + what + more);
  } else {
    diagnostics.warning(mark, std::to_string(wrong) + " of " + std::to_string(all) +
                                  " drawn episodes begin " + what + more);
  }
}

/// Checks drawn starts. An episode that begins with a failure ends after its first step, and a goal
/// below the ground is never reached. If this holds for all starts, flight and learning are
/// impossible; if for some, these episodes are lost.
void try_starts(const std::shared_ptr<const CompiledScenario>& compiled, Diagnostics& diagnostics) {
  Simulation simulation(compiled, 0, 0);
  const bool has_ground = compiled->scenario().contact.ground;
  int failed = 0, buried = 0, begun = 0;  // faults are reported elsewhere
  std::string how;
  double lowest = kInfinity;
  for (int k = 0; k < kStarts; ++k) {
    simulation.reset();
    if (simulation.fault()) continue;
    ++begun;
    const std::string failure = present_failure(simulation);
    const double goal = lowest_goal(simulation);
    if (has_ground && goal < 0.0) {
      ++buried;
      lowest = min(lowest, goal);
    }
    if (!failure.empty() && failed++ == 0) {
      how = failure + ", such as with " + places_text(simulation);
    }
  }
  tell_of_starts(mark_of_starts(*compiled), failed, begun,
                 "as a failure: ", how + ": move starts or goals, or widen that limit",
                 diagnostics);
  const Scenario& scenario = compiled->scenario();
  tell_of_starts(own_parameter(scenario, scenario.task).value_or(scenario.task.mark), buried, begun,
                 "with a goal below the ground, ",
                 "at z = " + rounded(lowest) + " m: raise it, or take `contact: {ground: false}`",
                 diagnostics);
}

}  // namespace

void fly_for_a_moment(const std::shared_ptr<const CompiledScenario>& compiled,
                      Diagnostics& diagnostics) {
  LaneState own;  // the scenario's own start, before any draw
  write_default_state(compiled->world(), own);
  warn_of_overlaps(*compiled, own.bodies, diagnostics);
  Simulation simulation(compiled, 0, 0);
  simulation.reset();
  if (simulation.fault()) {
    diagnostics.warning(
        {compiled->scenario().file, 0, 0},
        "the first start that is drawn is a fault: " + compiled->fault_reason(simulation.status()));
  }
  warn_of_light_links(*compiled, diagnostics);
  warn_of_stiff_joints(*compiled, diagnostics);
  try_starts(compiled, diagnostics);
  static_cast<void>(simulation.goals());  // also tries the task's goal()
  int faults = 0;
  std::uint64_t status = 0;
  for (int k = 0; k < kSteps; ++k) {
    if (simulation.done()) simulation.reset();
    const std::vector<float> idle(static_cast<std::size_t>(simulation.action_size()), 0.0f);
    simulation.step(
        k % 2 == 0 ? idle : random_action(simulation.action_size(), static_cast<std::uint64_t>(k)));
    if (!simulation.fault()) continue;
    ++faults;
    status = simulation.status();
  }
  tell_of_faults(*compiled, faults, status, diagnostics);
}

}  // namespace skybody
