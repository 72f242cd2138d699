// Closed loop of `nmpc` with one rigid body and lagging rotors, implemented here: Newton and Euler,
// small explicit steps, rotor speeds by eq. 2. It does not use the controller's own model.
#pragma once

#include <cmath>
#include <functional>

#include "core/base/math/quat.h"
#include "plugins/api/reference_point.h"
#include "tests/unit/plugin_harness.h"

namespace skybody::testing {

using Reference = std::function<ReferencePoint<double>(double time)>;

/// A point at rest.
inline Reference hover_at(const Vec3<double>& place, double yaw = 0.0) {
  return [=](double) { return ReferencePoint<double>{place, {}, {}, {}, {}, yaw, 0.0}; };
}

/// One axis of a sum of sines: amplitude, rate [rad/s], phase [rad].
struct Sine {
  double amplitude, rate, phase;
  double derivative(double t, int order) const {
    return amplitude * std::pow(rate, order) * std::sin(rate * t + phase + order * kPi / 2.0);
  }
};
inline Reference sines(const Vec3<double>& centre, const std::array<Sine, 3>& axes) {
  return [=](double t) {
    const auto at = [&](int order) {
      return Vec3<double>{axes[0].derivative(t, order), axes[1].derivative(t, order),
                          axes[2].derivative(t, order)};
    };
    return ReferencePoint<double>{centre + at(0), at(1), at(2), at(3), at(4), 0.0, 0.0};
  };
}

/// A vehicle of a PluginWorld, and the controller in front of its rotors.
class NmpcFlight {
 public:
  /// @param from  initial position and velocity; none: at rest at 1 m
  NmpcFlight(PluginWorld& plugin_world, const Parameters& given, const Reference& from = {})
      : world(plugin_world),
        nmpc("nmpc", world, given),
        group(nmpc.group(1)),
        speed(world.rotors.size(), 0.0) {
    const double hover = world.bodies[0].mass * world.gravity / static_cast<double>(speed.size());
    for (std::size_t i = 0; i < speed.size(); ++i) {
      speed[i] = std::sqrt(hover / world.rotors[i].constants[SKYBODY_ROTOR_THRUST_CONSTANT]);
    }
    if (!from) return;
    p = from(0.0).position;
    v = from(0.0).velocity;
  }

  /// One iteration of the controller at the present time.
  void control(const Reference& reference, double node_step = 0.05) {
    const double values[13] = {p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z};
    std::copy(values, values + 13, group.bodies.begin());
    group.rotor_speed = speed;
    const Values<double> input(group.input.data(), 1, true);
    const int points = static_cast<int>(group.input.size()) / kReferencePointSize;
    for (int i = 0; i < points; ++i) set_reference_point(input, reference(time + node_step * i), i);
    nmpc.call(Instance::Call::kControl, group);
  }

  /// Moves the vehicle by a physics step with the controller's last output.
  void step() {
    Vec3<double> force{0, 0, 0}, torque{0, 0, 0};
    for (std::size_t i = 0; i < speed.size(); ++i) {
      const SkybodyRotorInfo& r = world.rotors[i];
      const double kf = r.constants[SKYBODY_ROTOR_THRUST_CONSTANT];
      const double wanted = std::sqrt(group.output[i] / kf);
      const double tau =
          r.constants[wanted > speed[i] ? SKYBODY_ROTOR_TAU_UP : SKYBODY_ROTOR_TAU_DOWN];
      speed[i] = wanted + (speed[i] - wanted) * std::exp(-world.dt / tau);
      const double f = gain[i % 4] * kf * speed[i] * speed[i];
      const Vec3<double> axis{r.axis[0], r.axis[1], r.axis[2]};
      const Vec3<double> push = axis * f;
      force += push;
      torque += cross(Vec3<double>{r.position[0], r.position[1], r.position[2]}, push) -
                axis * (r.direction * f * r.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] / kf);
    }
    const double* j = world.bodies[0].inertia;
    const Vec3<double> rest = torque - cross(w, Vec3<double>{j[0] * w.x, j[1] * w.y, j[2] * w.z});
    const Vec3<double> air = rotate_inverse(q, v - wind);
    const Vec3<double> pull = rotate(q, force - multiply_elements(drag, air)) / mass();
    const Vec3<double> a = pull - Vec3<double>{0, 0, world.gravity};
    const Vec3<double> before = v;
    v += a * world.dt;
    p += (before + v) * (0.5 * world.dt);
    const Vec3<double> turned = w;
    w += Vec3<double>{rest.x / j[0], rest.y / j[1], rest.z / j[2]} * world.dt;
    q = normalized(q * from_rotation_vector((turned + w) * (0.5 * world.dt)));
    time += world.dt;
  }

  double mass() const { return mass_factor * world.bodies[0].mass; }

  /// Flies for `seconds` more, with ten physics steps per iteration.
  /// @returns root mean square position error [m] after the first `settle` seconds
  double fly(const Reference& reference, double seconds, double settle = 0.0,
             const std::function<void()>& each_step = {}) {
    const auto steps = static_cast<int>(std::lround(seconds / world.dt));
    double sum = 0.0;
    int count = 0;
    for (int n = 0; n < steps; ++n) {
      if (n % 10 == 0) control(reference);
      if (each_step) each_step();
      step();
      if (n * world.dt < settle) continue;
      sum += squared_norm(p - reference(time).position);
      ++count;
    }
    return std::sqrt(sum / count);
  }

  double info(int word) const { return group.buffer[static_cast<std::size_t>(word)]; }
  double solves() const { return info(0); }
  double failures() const { return info(1); }

  PluginWorld& world;
  Instance nmpc;
  Group group;
  Vec3<double> p{0, 0, 1}, v{0, 0, 0}, w{0, 0, 0};
  Quat<double> q{1, 0, 0, 0};
  std::vector<double> speed;
  double time = 0.0;
  double mass_factor = 1.0;
  double gain[4] = {1.0, 1.0, 1.0, 1.0};  ///< of each rotor's thrust
  Vec3<double> wind{0, 0, 0};             ///< [m/s]
  Vec3<double> drag{0.1, 0.1, 0.0};       ///< along body axes [N s/m]
};

}  // namespace skybody::testing
