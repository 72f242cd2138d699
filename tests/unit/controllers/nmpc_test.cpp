// `nmpc` in closed loop with the vehicle of nmpc_flight.h, and at its limits.
#include <cmath>

#include "controllers/nmpc/solver.h"
#include "tests/unit/controllers/nmpc_flight.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using ::testing::HasSubstr;

/// Peak speed 1.5 m/s, as in the paper's training family.
Reference lissajous() {
  return sines({0, 0, 1.5}, {Sine{1.0, 1.0, 0.0}, Sine{0.5, 2.0, 0.3}, Sine{0.2, 1.5, 0.1}});
}

/// A figure of eight whose maximum speed is 10.1 m/s, at the crossing; 1.5 g.
Reference figure_of_eight() {
  return sines({0, 0, 3}, {Sine{8.0, 0.9, 0.0}, Sine{4.0, 1.8, 0.0}, Sine{0.0, 1.0, 0.0}});
}

class NmpcTest : public ::testing::Test {
 protected:
  NmpcTest() { world.add_quad("quad"); }
  NmpcFlight on(const Reference& reference, const Parameters& given = {{"preview", true}}) {
    return NmpcFlight(world, given, reference);
  }
  PluginWorld world;
};

TEST_F(NmpcTest, HoversWhereItIsTold) {
  NmpcFlight flight(world, {});
  flight.fly(hover_at({0.8, -0.8, 1.8}, 0.6), 4.0);
  EXPECT_LT(norm(flight.p - Vec3<double>{0.8, -0.8, 1.8}), 1e-3);
  EXPECT_NEAR(yaw(flight.q), 0.6, 1e-3);
  EXPECT_EQ(flight.failures(), 0.0);
  EXPECT_EQ(flight.solves(), 400.0);
}

TEST_F(NmpcTest, KeepsToTheLissajousWithinTwoCentimetres) {
  EXPECT_LT(on(lissajous()).fly(lissajous(), 8.0, 1.0), 0.02);
  EXPECT_LT(on(lissajous(), {}).fly(lissajous(), 8.0, 1.0), 0.02) << "with one point";
}

TEST_F(NmpcTest, KeepsToTheFigureOfEightAtTenMetresASecond) {
  NmpcFlight flight = on(figure_of_eight());
  EXPECT_LT(flight.fly(figure_of_eight(), 14.0, 2.0), 0.15);
  EXPECT_EQ(flight.failures(), 0.0);
}

TEST_F(NmpcTest, WithstandsWindWithGusts) {
  NmpcFlight flight = on(lissajous());
  flight.drag = {0.3, 0.3, 0.15};  // 1 m/s^2 at 5 m/s
  const auto gusts = [&] {
    const double t = flight.time;
    flight.wind = {5.0 + 1.5 * std::sin(2.0 * t), 1.5 * std::sin(3.1 * t), 0.8 * std::sin(4.3 * t)};
  };
  EXPECT_LT(flight.fly(lissajous(), 8.0, 1.0, gusts), 0.10);
}

TEST_F(NmpcTest, WithstandsMoreMassAndAWeakRotor) {
  NmpcFlight heavy = on(lissajous());
  heavy.mass_factor = 1.1;
  EXPECT_LT(heavy.fly(lissajous(), 8.0, 2.0), 0.05);
  NmpcFlight weak = on(lissajous());
  weak.gain[2] = 0.8;
  EXPECT_LT(weak.fly(lissajous(), 8.0, 2.0), 0.05);
}

TEST_F(NmpcTest, EstimateOfAConstantForceIsThatForceAndLeavesNoError) {
  NmpcFlight flight(world, {});
  flight.drag = {0, 0, 0};
  flight.mass_factor = 1.05;
  flight.fly(hover_at({0, 0, 1}), 6.0);
  // At rest the thrust equals the heavier weight: the nominal model does not explain 5 % of g.
  EXPECT_NEAR(flight.info(7), -0.05 * 9.81, 1e-3);
  EXPECT_NEAR(flight.info(5), 0.0, 1e-3);
  EXPECT_LT(norm(flight.p - Vec3<double>{0, 0, 1}), 1e-3);
}

TEST_F(NmpcTest, RightsItselfFromUpsideDown) {
  for (const Quat<double>& start :
       {Quat<double>{0, 1, 0, 0}, Quat<double>{0, 0, 1, 0}, Quat<double>{0, 0.8, 0.6, 0},
        Quat<double>{0.1, 0.7, -0.7, 0}}) {
    NmpcFlight flight(world, {});
    flight.p = {0, 0, 5};
    flight.q = normalized(start);
    flight.fly(hover_at({0, 0, 5}), 6.0);
    EXPECT_LT(norm(flight.p - Vec3<double>{0, 0, 5}), 0.01);
    EXPECT_NEAR(tilt_cosine(flight.q), 1.0, 1e-4);
  }
}

TEST_F(NmpcTest, FliesSixTiltedRotors) {
  PluginWorld hexa;
  hexa.add_robot("hexa", 0, 0, 1);
  hexa.add_body(0, "base", -1, 1, 1.5, {0.03, 0.04, 0.06});
  for (int i = 0; i < 6; ++i) {
    const double a = 1.0471975511965976 * i;
    hexa.add_rotor(0, {0.215 * std::cos(a), 0.215 * std::sin(a), 0.0}, i % 2 == 0 ? 1.0 : -1.0);
    double* axis = hexa.rotors.back().axis;
    const double s = i % 2 == 0 ? 0.2 : -0.2;
    axis[0] = -s * std::sin(a);
    axis[1] = s * std::cos(a);
    axis[2] = std::sqrt(1.0 - s * s);
  }
  NmpcFlight flight(hexa, {});
  flight.p = {0.5, 0.5, 0.5};
  flight.fly(hover_at({0, 0, 1}, 0.5), 6.0);
  EXPECT_LT(norm(flight.p - Vec3<double>{0, 0, 1}), 2e-3);
  EXPECT_NEAR(yaw(flight.q), 0.5, 2e-3);
}

TEST_F(NmpcTest, ThrustsStayWithinTheRotorsLimits) {
  const Instance instance("nmpc", world, {{"min_share", 0.05}});
  std::mt19937_64 generator(3);
  Group g = instance.group(1);
  const double full = 1.9533e-6 * 2246.0 * 2246.0;
  for (int i = 0; i < 300; ++i) {
    scatter(g, instance.declared, generator);
    instance.call(Call::kControl, g);
    for (const double f : g.output) {
      EXPECT_GE(f, 0.05 * full * (1.0 - 1e-12));
      EXPECT_LE(f, full * (1.0 + 1e-12));
    }
  }
}

TEST_F(NmpcTest, AReferenceThatIsNoNumberKeepsTheLastInputs) {
  NmpcFlight flight = on(lissajous());
  flight.fly(lissajous(), 1.0);
  const double before = flight.failures();
  const Reference broken = [](double t) {
    ReferencePoint<double> point = lissajous()(t);
    point.position.y = std::nan("");
    return point;
  };
  flight.control(broken);
  EXPECT_EQ(flight.failures(), before + 1.0);
  for (const double f : flight.group.output) {
    EXPECT_GT(f, 1.0);
    EXPECT_LT(f, 9.0);
  }
  EXPECT_LT(flight.fly(lissajous(), 4.0, 1.0), 0.02) << "it remembers no NaN";
}

TEST_F(NmpcTest, BeginsWithNoNumberAtItsLeastThrust) {
  NmpcFlight flight(world, {{"min_share", 0.1}});
  flight.control([](double) {
    const double nan = std::nan("");
    return ReferencePoint<double>{{nan, nan, nan}, {nan, nan, nan}, {}, {}, {}, nan, nan};
  });
  EXPECT_EQ(flight.failures(), 1.0);
  for (const double f : flight.group.output) EXPECT_TRUE(std::isfinite(f));
  flight.fly(hover_at({0, 0, 1}), 4.0);
  EXPECT_LT(norm(flight.p - Vec3<double>{0, 0, 1}), 1e-2);
}

TEST_F(NmpcTest, ZeroThrustIsFlownAsFreeFall) {
  const Reference fall = [](double t) {
    return ReferencePoint<double>{
        {0, 0, 50 - 4.905 * t * t}, {0, 0, -9.81 * t}, {0, 0, -9.81}, {}, {}, 0.0, 0.0};
  };
  NmpcFlight flight = on(fall);
  for (double& w : flight.speed) w = 0.0;
  flight.drag = {0, 0, 0};
  EXPECT_LT(flight.fly(fall, 1.5), 1e-3);
  EXPECT_EQ(flight.failures(), 0.0);
  for (const double f : flight.group.output) EXPECT_NEAR(f, 0.0, 1e-2);
}

TEST_F(NmpcTest, APlanThatIsNotSolvedKeepsTheLimitsAndIsCounted) {
  NmpcFlight flight(world, {{"max_iterations", 1}});
  flight.p = {4, 3, 0};
  flight.control(hover_at({0, 0, 1}));
  EXPECT_EQ(flight.failures(), 1.0);
  for (const double f : flight.group.output) EXPECT_NEAR(f, 1.54 * 9.81 / 4.0, 1e-9);
}

TEST_F(NmpcTest, AfterAFailureItBeginsAnewFromWhatTheReferenceTakes) {
  constexpr std::size_t kFirstInput = 25;  // after 21 words and one share for each of four rotors
  NmpcFlight flight(world, {{"max_iterations", 1}});
  flight.control(hover_at({0, 0, 1}));
  ASSERT_EQ(flight.failures(), 0.0) << "no rotor is at a limit";
  for (std::size_t i = kFirstInput; i < flight.group.buffer.size(); ++i) {
    flight.group.buffer[i] = 1.0;  // a diverged plan
  }
  flight.p = {4, 3, 0};
  flight.control(hover_at({0, 0, 1}));
  EXPECT_EQ(flight.failures(), 1.0);
  for (const double f : flight.group.output) EXPECT_NEAR(f, 9.85, 0.01) << "the last inputs";
  flight.control(hover_at({0, 0, 1}));
  EXPECT_EQ(flight.failures(), 2.0);
  for (const double f : flight.group.output) EXPECT_LT(f, 9.0) << "those of the reference";
}

TEST_F(NmpcTest, RecoversFromTumblingStarts) {
  std::mt19937_64 generator(5);
  const auto draw = [&](double most) {
    return most * (2.0 * static_cast<double>(generator() >> 11) * 0x1p-53 - 1.0);
  };
  const Vec3<double> place{0, 0, 30};
  for (int i = 0; i < 15; ++i) {
    NmpcFlight flight(world, {});
    flight.p = place + Vec3<double>{draw(3), draw(3), draw(3)};
    flight.v = {draw(6), draw(6), draw(6)};
    flight.w = {draw(8), draw(8), draw(4)};
    flight.q = normalized(Quat<double>{draw(1), draw(1), draw(1), draw(1)});
    flight.fly(hover_at(place, draw(3)), 7.0);
    EXPECT_LT(norm(flight.p - place), 0.05) << "start " << i;
  }
}

TEST_F(NmpcTest, GoesOnFromItsWordsAlone) {
  NmpcFlight flight = on(figure_of_eight());
  flight.fly(figure_of_eight(), 1.23);
  NmpcFlight copy(world, {{"preview", true}});
  copy.group = flight.group;
  copy.p = flight.p, copy.v = flight.v, copy.q = flight.q, copy.w = flight.w;
  copy.speed = flight.speed;
  copy.time = flight.time;
  flight.fly(figure_of_eight(), 0.5);
  copy.fly(figure_of_eight(), 0.5);
  EXPECT_TRUE(flight.group.same_bits(copy.group));
}

TEST_F(NmpcTest, EveryInstructionSetGivesTheSameBits) {
  constexpr int kLanes = SKYBODY_GROUP_LANES;
  const Instance instance("nmpc", world, {{"horizon", 8}});
  std::vector<Group> groups;
  for (int set = 0; set < kIsaCount; ++set) {
    if (!machine_has(kIsas[set])) continue;
    std::mt19937_64 generator(11);
    Group& g = groups.emplace_back(instance.group(kLanes));
    for (int round = 0; round < 20; ++round) {
      scatter(g, instance.declared, generator);
      const auto mask = static_cast<std::uint32_t>(generator());
      const Group before = g;
      instance.call(Call::kControl, g, mask, set);
      for (int l = 0; l < kLanes; ++l) {
        if (((mask >> l) & 1u) != 0) continue;
        Group one = before.alone(l);
        one.take_scratch(g.alone(l), true);
        ASSERT_TRUE(one.same_bits(g.alone(l))) << "lane " << l << " was not to be served";
      }
    }
    EXPECT_TRUE(g.same_bits(groups.front())) << "instruction set " << set;
  }
}

TEST(NmpcObserver, AnAccelerometerTellsWhatActsBesideRotorsAndDrag) {
  using namespace nmpc;
  Model model;
  model.rotors = 2;
  model.rotor[0].acceleration = {0.1, 0.0, 8.0};
  model.rotor[1].acceleration = {-0.2, 0.3, 9.0};
  model.drag = {0.2, 0.3, 0.1};
  Motion motion{{0, 0, 0},
                {3, -2, 1},
                from_rotation_vector(Vec3<double>{0.3, -0.5, 0.8}),
                {0, 0, 0},
                {0.4, 0.7}};
  const Vec3<double> wind{0.5, -1.5, 0.25};
  const Vec3<double> air = rotate_inverse(motion.rotation, motion.velocity);
  const Vec3<double> felt = model.rotor[0].acceleration * 0.4 + model.rotor[1].acceleration * 0.7 -
                            multiply_elements(model.drag, air) +
                            rotate_inverse(motion.rotation, wind);
  EXPECT_LT(norm(observe_force(model, motion, felt) - wind), 1e-14);
}

TEST_F(NmpcTest, BadSettingsAreRefused) {
  EXPECT_THAT(refusal("nmpc", world, {{"node_step", 0.005}}),
              HasSubstr("`period` is 0.01 s, above `node_step` 0.005 s"));
  EXPECT_THAT(refusal("nmpc", world, {{"position_min", std::vector<double>{0, 6, 0}}}),
              HasSubstr("`position_min[1]` 6 is not below `position_max[1]` 5"));
  PluginWorld many;
  many.add_robot("many", 0, 0, 1);
  many.add_body(0, "base", -1, 1, 1.5, {0.03, 0.04, 0.06});
  for (int i = 0; i < 12; ++i) {
    many.add_rotor(0, {0.3 * std::cos(0.5236 * i), 0.3 * std::sin(0.5236 * i), 0.0},
                   i % 2 == 0 ? 1.0 : -1.0);
  }
  EXPECT_THAT(refusal("nmpc", many, {}),
              HasSubstr("`horizon` 20 times 12 rotors are 240 inputs; allowed: up to 160: shorten "
                        "it to 13"));
}

TEST_F(NmpcTest, RotorsThatCannotControlAreRefused) {
  PluginWorld silent = world;
  for (auto& r : silent.rotors) r.constants[SKYBODY_ROTOR_MOMENT_CONSTANT] = 0.0;
  EXPECT_THAT(refusal("nmpc", silent, {}),
              HasSubstr("cannot give yaw torque independently, which nmpc"));
  PluginWorld bare;
  bare.add_robot("bare", 0, 0, 1);
  bare.add_body(0, "base", -1, 1, 1.0, {1, 1, 1});
  EXPECT_THAT(refusal("nmpc", bare, {}), HasSubstr("robot `bare` has no rotors"));
  PluginWorld arm = world;
  arm.add_arm_link("upper");
  arm.rotors.back().body = static_cast<int>(arm.bodies.size()) - 1;
  EXPECT_THAT(refusal("nmpc", arm, {}), HasSubstr("sits behind a joint, on `upper`"));
}

}  // namespace
}  // namespace skybody::testing
