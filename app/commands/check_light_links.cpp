#include "app/commands/check_light_links.h"

#include <cmath>
#include <string>
#include <vector>

#include "app/report/rounded.h"
#include "core/base/math/inertia.h"
#include "core/model/model_marks.h"

namespace skybody {
namespace {

/// Step size as a fraction of a link's time constant, sqrt(inertia / weight's moment). Measured on
/// chains of 2 to 16 links of 0.1 g to 10 g with 0.2 kg to 2 kg at their end, swinging and whipping
/// below a base. From kFailingShare on flights end in faults. At kHoldingShare all keep their
/// energy within 5 % of the swing's energy.
constexpr double kFailingShare = 0.08, kHoldingShare = 0.01;

/// Load of a body on its parent: the body and its descendants, as if all hung straight down from
/// its joint.
struct Hanging {
  double mass = 0.0;     ///< total mass [kg]
  double carried = 0.0;  ///< effective mass across the line, seen by the parent [kg]
  double time = 0.0;     ///< sqrt(inertia / weight's moment) [s]; infinite: no joint that swings
};

double distance(const Vec3<double>& a, const Vec3<double>& b) { return norm(a - b); }

bool swings(JointType type) {
  return type == JointType::kPin || type == JointType::kUniversal || type == JointType::kBall;
}

/// Computes the loads from the leaves to the base, one per body.
std::vector<Hanging> hang(const RobotModel& model, double gravity) {
  const std::size_t count = model.bodies.size();
  std::vector<Hanging> hanging(count);
  std::vector<double> moment(count, 0.0), inertia(count, 0.0), weight(count, 0.0);
  for (std::size_t i = count; i-- > 0;) {  // children come after their parents
    const Body& body = model.bodies[i];
    const Vec3<double> pivot = body.joint.frame_in_body.position;
    Hanging& h = hanging[i];
    const double arm = distance(body.mass.com, pivot);
    h.mass += body.mass.mass;
    h.carried += body.mass.mass;
    moment[i] += body.mass.mass * arm;
    weight[i] += gravity * body.mass.mass * arm;
    inertia[i] += eigenvalues(body.mass.inertia).z + body.mass.mass * arm * arm;
    h.time = kInfinity;
    if (swings(body.joint.type) && weight[i] > 0.0) {
      h.time = std::sqrt(inertia[i] / weight[i]);
      h.carried -= moment[i] * moment[i] / inertia[i];
    }
    if (body.joint.parent < 0) continue;
    const auto parent = static_cast<std::size_t>(body.joint.parent);
    const double reach = distance(body.joint.frame_in_parent.position,
                                  model.bodies[parent].joint.frame_in_body.position);
    hanging[parent].mass += h.mass;
    hanging[parent].carried += h.carried;
    moment[parent] += h.carried * reach;
    inertia[parent] += h.carried * reach * reach;
    weight[parent] += gravity * h.mass * reach;
  }
  return hanging;
}

}  // namespace

void warn_of_light_links(const CompiledScenario& compiled, Diagnostics& diagnostics) {
  const Scenario& scenario = compiled.scenario();
  const double dt = scenario.stepping.dt;
  const double gravity = norm(scenario.gravity());
  if (is_error_controlled(scenario.stepping.integrator) || gravity == 0.0) return;
  for (const RobotUse& robot : scenario.robots) {
    const std::vector<Hanging> hanging = hang(robot.model, gravity);
    std::size_t worst = 0;
    for (std::size_t i = 0; i < hanging.size(); ++i) {
      if (hanging[i].time < hanging[worst].time) worst = i;
    }
    const double time = hanging[worst].time;
    if (dt <= kFailingShare * time) continue;
    const Body& body = robot.model.bodies[worst];
    const double light = body.mass.mass, heavy = hanging[worst].mass - light;
    const double enough = light * (dt * dt) / (kFailingShare * kFailingShare * time * time);
    const bool has_marks = robot.model.marks && !robot.model.marks->bodies[worst].mass.file.empty();
    diagnostics.warning(has_marks ? robot.model.marks->bodies[worst].mass : robot.mark,
                        "link `" + body.name + "` of robot `" + robot.name + "` has " +
                            rounded(light) + " kg and carries " + rounded(heavy) +
                            " kg: where these swing it whips, and steps of " + rounded(dt) +
                            " s gain energy or end in a fault; give such links " + rounded(enough) +
                            " kg, or take a `dt` of " + rounded(kHoldingShare * time) +
                            " s, which held in all that was measured");
  }
}

}  // namespace skybody
