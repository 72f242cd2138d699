// position -> attitude -> ctbr in closed loop with one rigid body and rotor lag, written out here
// (Newton and Euler, explicit steps): signs, units and default gains fit together.
#include <cmath>

#include "core/base/quat.h"
#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;

/// QDrone2's base with four lagging rotors, or a wrench at its centre of mass.
class Flight {
 public:
  explicit Flight(const PluginWorld& plugin_world) : world(plugin_world) {}

  void step(const std::vector<double>& output, bool rotors) {
    Vec3<double> force{0, 0, 0}, torque{0, 0, 0};
    if (!rotors) {
      force = {output[0], output[1], output[2]};
      torque = {output[3], output[4], output[5]};
    }
    for (std::size_t i = 0; rotors && i < 4; ++i) {
      const SkybodyRotorInfo& r = world.rotors[i];
      const double tau = output[i] > speed[i] ? r.constants[SKYBODY_ROTOR_TAU_UP]
                                              : r.constants[SKYBODY_ROTOR_TAU_DOWN];
      speed[i] = output[i] + (speed[i] - output[i]) * std::exp(-world.dt / tau);
      const double f = r.constants[SKYBODY_ROTOR_THRUST_CONSTANT] * speed[i] * speed[i];
      force.z += f;
      torque +=
          cross(Vec3<double>{r.position[0], r.position[1], r.position[2]}, Vec3<double>{0, 0, f});
      torque.z -= r.direction * r.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] * speed[i] * speed[i];
    }
    const double* j = world.bodies[0].inertia;
    const Vec3<double> momentum{j[0] * w.x, j[1] * w.y, j[2] * w.z};
    const Vec3<double> rest = torque - cross(w, momentum);
    v += (rotate(q, force) / world.bodies[0].mass - Vec3<double>{0, 0, world.gravity}) * world.dt;
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
};

/// Mean error over the last of eight seconds after a jump of 1.4 m and 0.6 rad.
void expect_arrival(const Parameters& rate_control, bool rotors) {
  PluginWorld world;
  world.add_quad("quad");
  const Instance position("position", world), attitude("attitude", world),
      rates("ctbr", world, rate_control);
  Flight flight(world);
  Group a = position.group(1), b = attitude.group(1), c = rates.group(1);
  flight.show(c);
  rates.call(Call::kReset, c);
  a.input = {0.8, -0.8, 1.8, 0.6};
  double error = 0.0;
  for (int n = 0; n < 8000; ++n) {
    for (Group* g : {&a, &b, &c}) flight.show(*g);
    position.call(Call::kControl, a);
    b.input = a.output;
    attitude.call(Call::kControl, b);
    c.input = b.output;
    rates.call(Call::kControl, c);
    flight.step(c.output, rotors);
    if (n >= 7000) error += norm(flight.p - Vec3<double>{0.8, -0.8, 1.8}) / 1000.0;
  }
  EXPECT_LT(error, 1e-3);
  EXPECT_NEAR(yaw(flight.q), 0.6, 1e-3);
  EXPECT_NEAR(tilt_cosine(flight.q), 1.0, 1e-6);
}

TEST(Cascade, HoversThroughTheRotors) { expect_arrival({}, true); }
TEST(Cascade, HoversOnTheBody) { expect_arrival({{"apply", "body"}}, false); }
TEST(Cascade, HoversWithIdealRates) { expect_arrival({{"apply", "body"}, {"pd", false}}, false); }

}  // namespace
}  // namespace skybody::testing
