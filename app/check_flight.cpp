#include "app/check_flight.h"

#include <map>
#include <vector>

#include "core/base/math.h"
#include "core/base/random.h"
#include "core/io/text.h"
#include "core/model/fault_reason.h"
#include "core/physics/bodies/default_state.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

/// Steps: every phase of a plugin with a period of at most so many actions is met.
constexpr int kSteps = 8;
/// A robot that stands on the ground sinks in by about ContactSettings::penetration.
constexpr double kDeep = 10.0;

std::string robot_of(const CompiledScenario& compiled, int body) {
  const World& world = compiled.world();
  const int robot = world.bodies[static_cast<std::size_t>(body)].robot;
  return "robot `" + compiled.scenario().robots[static_cast<std::size_t>(robot)].name + "`";
}

std::string other_of(const CompiledScenario& compiled, const Contact& contact) {
  if (contact.other == kGround) return "the ground";
  if (is_obstacle(contact.other)) {
    const auto place = static_cast<std::size_t>(obstacle_of(contact.other));
    return "the obstacle `" + compiled.scenario().obstacles[place].name + "`";
  }
  return robot_of(compiled, contact.other);
}

/// Contact pushes apart what begins inside one another, hard.
void warn_of_overlaps(const CompiledScenario& compiled, const std::vector<Contact>& contacts,
                      Diagnostics& diagnostics) {
  const double deep = kDeep * compiled.scenario().contact.penetration;
  std::map<std::string, double> depths;
  for (const Contact& contact : contacts) {
    const std::string robot = robot_of(compiled, contact.body);
    const std::string other = other_of(compiled, contact);
    if (contact.depth < deep || robot == other) continue;
    double& depth = depths[robot + " begins inside " + other];
    depth = max(depth, contact.depth);
  }
  for (const auto& [what, depth] : depths) {
    diagnostics.warning({compiled.scenario().file, 0, 0},
                        what + ", by " + format_number(depth) + " m; move its `pose`");
  }
}

/// Robots that are to hover, and would need speeds that their rotors do not reach.
void warn_of_weight(const CompiledScenario& compiled, Diagnostics& diagnostics) {
  const Scenario& scenario = compiled.scenario();
  for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
    const RobotUse& use = scenario.robots[r];
    if (use.rotor_speed >= 0.0) continue;
    const double speed = hover_rotor_speed(compiled.world(), static_cast<int>(r));
    double slowest = kInfinity;
    for (const Rotor& rotor : use.model.rotors) {
      slowest = min(slowest, rotor.constants[kMaxSpeed]);
    }
    if (speed <= slowest) continue;
    diagnostics.warning({scenario.file, 0, 0},
                        "robot `" + use.name + "` cannot hover: `rotor_speed: hover` is " +
                            format_number(speed) + " rad/s, and `max_speed` " +
                            format_number(slowest) + " rad/s");
  }
}

std::vector<float> random_action(int size, std::uint64_t step) {
  Random<double> random(RandomKey{0, 0}, 0, step, derive_stream("check.action"));
  std::vector<float> action(static_cast<std::size_t>(size));
  for (float& a : action) a = static_cast<float>(random.uniform(-1.0, 1.0));
  return action;
}

}  // namespace

void fly_for_a_moment(const std::shared_ptr<const CompiledScenario>& compiled,
                      Diagnostics& diagnostics) {
  Simulation simulation(compiled, 0, 0);
  simulation.reset();
  warn_of_overlaps(*compiled, simulation.contacts(), diagnostics);
  warn_of_weight(*compiled, diagnostics);
  static_cast<void>(simulation.goals());  // the task's goal() is tried, too
  int faults = 0;
  for (int k = 0; k < kSteps; ++k) {
    if (simulation.done()) simulation.reset();
    const std::vector<float> idle(static_cast<std::size_t>(simulation.action_size()), 0.0f);
    simulation.step(
        k % 2 == 0 ? idle : random_action(simulation.action_size(), static_cast<std::uint64_t>(k)));
    faults += simulation.fault() ? 1 : 0;
  }
  if (faults < kSteps) return;
  diagnostics.warning({compiled->scenario().file, 0, 0},
                      "every step of a trial flight ends in a fault: " +
                          fault_reason(simulation.status()) + "; `skybody run` shows more");
}

}  // namespace skybody
