// Worlds with coupled bodies, built by hand.
#pragma once

#include <string>
#include <vector>

#include "core/physics/coupling/coupling_start.h"
#include "tests/unit/physics/test_models.h"

namespace skybody::test {

inline RobotUse make_robot(const std::string& name, RobotModel model, Vec3<double> position) {
  RobotUse use;
  use.name = name;
  use.model = std::move(model);
  use.pose.position = position;
  return use;
}

/// A body with the inertia of a ball, without shapes.
inline RobotModel make_mass(double mass, double radius = 0.05) {
  const double inertia = 0.4 * mass * radius * radius;
  return make_free_body(mass, diagonal(inertia, inertia, inertia));
}

inline Coupling make_coupling(const std::string& name, CouplingKind kind, CouplingEnd a,
                              CouplingEnd b) {
  Coupling coupling;
  coupling.name = name;
  coupling.kind = kind;
  coupling.ends = {a, b};
  return coupling;
}
inline Coupling with_length(Coupling coupling, double length) {
  coupling.constants[kCouplingLength] = length;
  coupling.has_length = true;
  return coupling;
}

/// Robots in the air, without ground.
inline Scenario make_team(std::vector<RobotUse> robots, std::vector<Coupling> couplings,
                          IntegratorChoice integrator = IntegratorChoice::kMidpoint,
                          double dt = 0.001) {
  Scenario scenario;
  scenario.name = "test";
  scenario.stepping.dt = dt;
  scenario.stepping.integrator = integrator;
  scenario.contact.ground = false;
  scenario.robots = std::move(robots);
  scenario.couplings = std::move(couplings);
  fit_couplings(scenario);
  return scenario;
}

/// Position of an end of a coupling, W.
inline Vec3<double> end_of(const Bench& bench, int coupling, int end) {
  const auto& at = bench.world.scenario.couplings[static_cast<std::size_t>(coupling)]
                       .ends[static_cast<std::size_t>(end)];
  if (at.robot < 0) return at.point;
  const int first = bench.world.layout.robots[static_cast<std::size_t>(at.robot)].first_body;
  const BodyState& body = bench.state.bodies[static_cast<std::size_t>(first + at.body)];
  return body.position + rotate(body.rotation, at.point);
}
inline double distance_of(const Bench& bench, int coupling = 0) {
  return norm(end_of(bench, coupling, 0) - end_of(bench, coupling, 1));
}

/// Of all bodies, in a field of 9.81 m/s^2 [J].
inline double mechanical_energy(const Bench& bench) {
  double sum = 0.0;
  for (std::size_t i = 0; i < bench.world.bodies.size(); ++i) {
    const MassProperties& mass = bench.world.bodies[i].model->mass;
    const BodyState& body = bench.state.bodies[i];
    const Vec3<double> com = body.position + rotate(body.rotation, mass.com);
    sum += kinetic_energy(body, mass) - mass.mass * dot(bench.world.scenario.gravity(), com);
  }
  return sum;
}

/// Of all bodies: linear [N s], and angular about W's origin [N m s].
struct Momentum {
  Vec3<double> linear{0, 0, 0}, angular{0, 0, 0};
};
inline Momentum momentum(const Bench& bench) {
  Momentum sum;
  for (std::size_t i = 0; i < bench.world.bodies.size(); ++i) {
    const MassProperties& mass = bench.world.bodies[i].model->mass;
    const BodyState& body = bench.state.bodies[i];
    const Vec3<double> p = mass.mass * com_velocity(body, mass);
    sum.linear += p;
    sum.angular +=
        cross(body.position + rotate(body.rotation, mass.com), p) + spin_momentum(body, mass);
  }
  return sum;
}

}  // namespace skybody::test
