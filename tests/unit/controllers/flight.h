// One rigid body under chains of controllers, implemented here (Newton and Euler, explicit steps)
// without the engine.
#pragma once

#include <cmath>

#include "core/base/math/quat.h"
#include "plugins/api/reference_point.h"
#include "tests/unit/plugin_harness.h"

namespace skybody::testing {

/// QDrone2's base with four lagging rotors with drag, or a wrench at its centre of mass.
class Flight {
 public:
  explicit Flight(const PluginWorld& plugin_world) : world(plugin_world) {}

  void step(const std::vector<double>& output, bool rotors) {
    Vec3<double> force{0, 0, 0}, torque = other_torque;
    if (!rotors) {
      force = {output[0], output[1], output[2]};
      torque += {output[3], output[4], output[5]};
    }
    for (std::size_t i = 0; rotors && i < 4; ++i) add_rotor(i, output[i], force, torque);
    const double* j = world.bodies[0].inertia;
    const Vec3<double> momentum{j[0] * w.x, j[1] * w.y, j[2] * w.z};
    const Vec3<double> rest = torque - cross(w, momentum);
    v += ((rotate(q, force) + other_force) / world.bodies[0].mass -
          Vec3<double>{0, 0, world.gravity}) *
         world.dt;
    w += Vec3<double>{rest.x / j[0], rest.y / j[1], rest.z / j[2]} * world.dt;
    p += v * world.dt;
    q = normalized(q * from_rotation_vector(w * world.dt));
  }

  void show(Group& g) const {
    const double values[13] = {p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z};
    std::copy(values, values + 13, g.bodies.begin());
    std::copy(speed.begin(), speed.end(), g.rotor_speed.begin());
  }

  const PluginWorld& world;
  Vec3<double> p{0, 0, 1}, v{0, 0, 0}, w{0, 0, 0};
  Quat<double> q{1, 0, 0, 0};
  std::vector<double> speed = std::vector<double>(4, 1390.0);
  Vec3<double> other_force{0, 0, 0};   ///< W axes [N]
  Vec3<double> other_torque{0, 0, 0};  ///< B axes [N m]
  double weak_share = 1.0;             ///< remaining share of rotor 0's thrust and reaction
  bool spins = false;                  ///< accelerating rotors turn the body

 private:
  void add_rotor(std::size_t i, double command, Vec3<double>& force, Vec3<double>& torque) {
    const SkybodyRotorInfo& r = world.rotors[i];
    const double tau = command > speed[i] ? r.constants[SKYBODY_ROTOR_TAU_UP]
                                          : r.constants[SKYBODY_ROTOR_TAU_DOWN];
    const double before = speed[i];
    speed[i] = command + (speed[i] - command) * std::exp(-world.dt / tau);
    const double square = (i == 0 ? weak_share : 1.0) * speed[i] * speed[i];
    const double f = r.constants[SKYBODY_ROTOR_THRUST_CONSTANT] * square;
    const Vec3<double> at{r.position[0], r.position[1], r.position[2]};
    const Vec3<double> air = rotate_inverse(q, v) + cross(w, at);
    const double drag = r.constants[SKYBODY_ROTOR_DRAG_CONSTANT] * speed[i];
    const Vec3<double> push{-drag * air.x, -drag * air.y, f};
    force += push;
    torque += cross(at, push);
    torque.z -= r.direction * r.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] * square;
    if (!spins) return;
    const double growth = (speed[i] - before) / world.dt;
    torque.z -= r.direction * r.constants[SKYBODY_ROTOR_INERTIA] * growth;
  }
};

/// A controller of a chain and its parameters.
struct Link {
  std::string plugin;
  Parameters given;
};

/// A chain of controllers; the last one drives the rotors of a Flight.
class Chain {
 public:
  Chain(PluginWorld& world, const std::vector<Link>& links) {
    for (const Link& link : links) {
      instances_.push_back(std::make_unique<Instance>(link.plugin, world, link.given));
    }
    // Called when all parameters of the world are known.
    for (const auto& instance : instances_) groups.push_back(instance->group(1));
  }

  void reset(const Flight& flight) {
    for (std::size_t i = 0; i < groups.size(); ++i) {
      flight.show(groups[i]);
      instances_[i]->call(Instance::Call::kReset, groups[i]);
    }
  }

  /// Commands of the rotors [rad/s].
  const std::vector<double>& control(const Flight& flight, const std::vector<double>& input) {
    const std::vector<double>* given = &input;
    for (std::size_t i = 0; i < groups.size(); ++i) {
      flight.show(groups[i]);
      groups[i].input = *given;
      instances_[i]->call(Instance::Call::kControl, groups[i]);
      given = &groups[i].output;
    }
    return *given;
  }

  std::vector<Group> groups;  ///< one per controller: their complete saved state

 private:
  std::vector<std::unique_ptr<Instance>> instances_;
};

/// A point of a trajectory as a controller's input.
inline std::vector<double> trajectory_of(const ReferencePoint<double>& point) {
  const auto& [p, v, a, j, s, yaw, yaw_rate] = point;
  return {p.x, p.y, p.z, v.x, v.y, v.z, a.x, a.y, a.z, j.x, j.y, j.z, s.x, s.y, s.z, yaw, yaw_rate};
}

/// A reference at rest.
inline ReferencePoint<double> standing_at(const Vec3<double>& place, double yaw = 0.0) {
  ReferencePoint<double> point{};
  point.position = place;
  point.yaw = yaw;
  return point;
}

/// A Lissajous curve of 1.5 m/s at most, with a rotating heading.
inline ReferencePoint<double> lissajous(double t) {
  const double size[3] = {1.5, 1.2, 0.3}, rate[3] = {0.6, 0.9, 1.2}, phase[3] = {0.0, 1.3, 0.4};
  double d[5][3];
  for (int k = 0; k < 3; ++k) {
    const double w = rate[k], a = size[k], angle = w * t + phase[k];
    d[0][k] = a * std::sin(angle);
    d[1][k] = a * w * std::cos(angle);
    for (int n = 2; n < 5; ++n) d[n][k] = -w * w * d[n - 2][k];
  }
  const auto vector = [&](int n) { return Vec3<double>{d[n][0], d[n][1], d[n][2]}; };
  return {vector(0) + Vec3<double>{0, 0, 1.5},
          vector(1),
          vector(2),
          vector(3),
          vector(4),
          0.3 * t,
          0.3};
}

}  // namespace skybody::testing
