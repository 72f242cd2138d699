// position -> attitude -> ctbr in closed loop with one rigid body and rotor lag: signs, units and
// default gains are consistent.
#include "tests/unit/controllers/flight.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;

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
