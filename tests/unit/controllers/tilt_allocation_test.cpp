// tilt_allocation and full_pose on a hexacopter with tilting arms, by hand.
#include <cmath>

#include "core/base/math/quat.h"
#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using V = Vec3<double>;
using Q = Quat<double>;
using ::testing::HasSubstr;

constexpr double kThrustConstant = 1.9533e-6, kMomentConstant = 2.8401e-8;

class TiltTest : public ::testing::Test {
 protected:
  /// @param pairs  true: two rotors per arm; false: one, with alternating directions
  explicit TiltTest(bool pairs = true) : pairs_(pairs) {
    world.add_robot("omav", 0, 0, 1);
    world.add_body(0, "base", -1, SKYBODY_FREE, 1.7, {0.01, 0.01, 0.02});
    for (int i = 0; i < 6; ++i) add_arm("arm" + std::to_string(i), kPi / 6 + kPi / 3 * i, i);
  }

  void add_arm(const std::string& name, double azimuth, int i) {
    const int body = world.add_body(0, name, 0, SKYBODY_PIN, 0.1, {1e-4, 1e-4, 3e-5});
    SkybodyBodyInfo& info = world.bodies.back();
    info.joint_name = world.keep(name + "_tilt");
    const Q heading = from_axis_angle(V{0, 0, 1}, azimuth);
    const Q along = from_axis_angle(V{0, 1, 0}, kHalfPi);  // z of the joint along x of the arm
    const Q frame = heading * along;
    const double in_parent[7] = {
        0.3 * std::cos(azimuth), 0.3 * std::sin(azimuth), 0.0, frame.w, frame.x, frame.y, frame.z};
    const double in_body[7] = {0, 0, 0, along.w, along.x, along.y, along.z};
    std::copy(in_parent, in_parent + 7, info.joint_in_parent);
    std::copy(in_body, in_body + 7, info.joint_in_body);
    azimuths.push_back(azimuth);
    for (int layer = 0; layer < (pairs_ ? 2 : 1); ++layer) {
      world.add_rotor(0, {0.0, 0.0, layer == 0 ? 0.04 : -0.04}, (i + layer) % 2 == 0 ? 1.0 : -1.0);
      world.rotors.back().body = body;
    }
  }

  /// Force and moment about the middle, where the centre of mass is.
  std::array<double, 6> wrench(const std::vector<double>& output) const {
    V force{0, 0, 0}, moment{0, 0, 0};
    const std::size_t rotors = world.rotors.size();
    for (std::size_t i = 0; i < rotors; ++i) {
      const std::size_t arm = i * azimuths.size() / rotors;
      const V out{std::cos(azimuths[arm]), std::sin(azimuths[arm]), 0.0};
      const V up = rotate(from_axis_angle(out, output[rotors + arm]), V{0, 0, 1});
      const V push = up * (kThrustConstant * output[i] * output[i]);
      force += push;
      moment += cross(out * 0.3, push);
      moment -= up * (world.rotors[i].direction * kMomentConstant * output[i] * output[i]);
    }
    return {force.x, force.y, force.z, moment.x, moment.y, moment.z};
  }

  std::vector<double> control(const Instance& instance, const std::vector<double>& input,
                              double angle = 0.0) {
    Group g = instance.group(1);
    for (std::size_t i = 1; i < world.bodies.size(); ++i) {
      g.at(g.q, world.bodies[i].first_q) = angle;
    }
    g.input = input;
    instance.call(Call::kControl, g);
    return g.output;
  }

  PluginWorld world;
  std::vector<double> azimuths;

 private:
  bool pairs_;
};

class SingleTiltTest : public TiltTest {
 protected:
  SingleTiltTest() : TiltTest(false) {}
};

TEST_F(TiltTest, PairsGiveTheWrenchThatIsAskedFor) {
  const Instance instance("tilt_allocation", world, {{"least_share", 0.0}});
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int n = 0; n < 1000; ++n) {
    std::vector<double> u = {10, 10, 20, 1, 1, 1};
    for (double& x : u) x *= uniform(generator);
    const auto got = wrench(control(instance, u));
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(got[k], u[k], 1e-11) << n;
  }
}

TEST_F(SingleTiltTest, SingleRotorsWithTheirReactionsDoToo) {
  const Instance instance("tilt_allocation", world);
  const std::vector<double> u = {4, -3, 20, 0.5, -0.4, 0.6};
  const auto got = wrench(control(instance, u));
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(got[k], u[k], 1e-12);
}

TEST_F(TiltTest, HoverIsUprightAndEqual) {
  const Instance instance("tilt_allocation", world);
  const std::vector<double> out = control(instance, {0, 0, 23, 0, 0, 0});
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_NEAR(kThrustConstant * out[i] * out[i], 23.0 / 12.0, 1e-13);
  }
  for (std::size_t i = 12; i < 18; ++i) EXPECT_NEAR(out[i], 0.0, 1e-14);
}

TEST_F(TiltTest, AnglesGoTheShortWayAndStayWhereNothingPushes) {
  const Instance instance("tilt_allocation", world);
  // Upside down, from slightly more than half a turn: pi, not -pi.
  for (std::size_t i = 12; i < 18; ++i) {
    EXPECT_NEAR(control(instance, {0, 0, -23, 0, 0, 0}, 3.3)[i], kPi, 1e-13);
    EXPECT_NEAR(control(instance, {0, 0, 23, 0, 0, 0}, 6.0)[i], kTwoPi, 1e-13);
    EXPECT_EQ(control(instance, {0, 0, 0, 0, 0, 0}, 1.25)[i], 1.25);
  }
  EXPECT_EQ(control(instance, {0, 0, 0, 0, 0, 0})[0], 0.0);
}

TEST_F(TiltTest, ArmsStayWithinTheirLimits) {
  for (std::size_t i = 1; i < world.bodies.size(); ++i) {
    world.bodies[i].joint_is_limited = 1;
    world.bodies[i].joint_lower = -0.5;
    world.bodies[i].joint_upper = 0.5;
  }
  const Instance instance("tilt_allocation", world);
  const std::vector<double> out = control(instance, {100, 0, 500, 0, 0, 9});
  for (std::size_t i = 0; i < 12; ++i) EXPECT_LE(out[i], 2246.0 * (1.0 + 1e-12));
  for (std::size_t i = 12; i < 18; ++i) EXPECT_LE(std::fabs(out[i]), 0.5);
  ASSERT_EQ(instance.declared.controller.joints.size(), 6u);
  EXPECT_NEAR(instance.declared.controller.joints[0].stiffness, 1e-4 * 3600.0, 1e-15);
}

TEST_F(TiltTest, FullPoseBearsTheWeightAndLeansTowardsTheWishedAttitude) {
  const Instance instance("full_pose", world);
  Group g = instance.group(1);
  const Q tilted = from_axis_angle(V{1, 0, 0}, 0.4);
  const double pose[7] = {0, 0, 1, tilted.w, tilted.x, tilted.y, tilted.z};
  std::copy(pose, pose + 7, g.bodies.begin());
  g.input = {0.1, 0.0, 1.0, tilted.w, tilted.x, tilted.y, tilted.z};
  instance.call(Call::kControl, g);
  const V force = rotate(tilted, V{g.output[0], g.output[1], g.output[2]});
  EXPECT_NEAR(force.x, 2.3 * 4.0 * 0.1, 1e-13);
  EXPECT_NEAR(force.y, 0.0, 1e-13);
  EXPECT_NEAR(force.z, 2.3 * 9.81, 1e-12);
  for (std::size_t k = 3; k < 6; ++k) EXPECT_NEAR(g.output[k], 0.0, 1e-15);
  const Q more = from_axis_angle(V{1, 0, 0}, 0.5);
  g.input = {0.0, 0.0, 1.0, more.w, more.x, more.y, more.z};
  instance.call(Call::kControl, g);
  // Arms of 0.1 kg at 0.3 m, half of them across x: 3 x 0.1 x 0.09, and their own rotated moments.
  const double inertia = 0.01 + 6 * 0.1 * 0.09 / 2 + 6 * 1e-4;
  EXPECT_NEAR(g.output[3], inertia * 36.0 * 2.0 * std::sin(0.05), 1e-12);
}

TEST_F(TiltTest, TheCentreOfMassIsThatOfTheJointsStart) {
  // Arms that start rotated by a quarter turn have their masses, 0.1 m above the hubs' plane at
  // angle 0, in that plane.
  for (std::size_t i = 1; i < world.bodies.size(); ++i) world.bodies[i].com[2] = 0.1;
  const auto moment_of_push_along_x = [&] {
    return wrench(control(Instance("tilt_allocation", world, {{"least_share", 0.0}}),
                          {2, 0, 20, 0, 0, 0}))[4];
  };
  // The robot weighs 2.3 kg, its arms 0.6 kg. The wrench acts at the centre of mass.
  EXPECT_NEAR(moment_of_push_along_x(), 2.0 * 0.1 * 0.6 / 2.3, 1e-12);
  for (std::size_t i = 1; i < world.bodies.size(); ++i) world.bodies[i].joint_start = kHalfPi;
  EXPECT_NEAR(moment_of_push_along_x(), 0.0, 1e-12);
}

TEST_F(TiltTest, TakesWhatFilesRoundAndNamesWhatIsBeyond) {
  const auto with = [&](const V& axis, double x) {
    PluginWorld rounded = world;
    std::copy(&axis.x, &axis.x + 3, rounded.rotors[0].axis);
    rounded.rotors[0].position[1] = x;
    return rounded;
  };
  PluginWorld good = with({8e-4, 0, 1}, 1e-4);
  const Instance instance("tilt_allocation", good);
  const std::vector<double> out = control(instance, {0, 0, 23, 0, 0, 0});
  EXPECT_NEAR(kThrustConstant * out[0] * out[0], 23.0 / 12.0, 1e-3);
  PluginWorld askew = with({0.01, 0, 1}, 0.0);
  EXPECT_THAT(refusal("tilt_allocation", askew, {}),
              HasSubstr("rotor `rotor0` pushes 0.01 rad off the plane across the axis of joint "
                        "`arm0_tilt`; tilt_allocation allows 0.002: check `position` and `axis` in "
                        "the rotors file"));
  PluginWorld beside = with({0, 0, 1}, 0.002);
  EXPECT_THAT(refusal("tilt_allocation", beside, {}),
              HasSubstr("rotor `rotor0` pushes 0.002 m beside the axis of joint `arm0_tilt`; "
                        "tilt_allocation allows 0.001: "));
}

TEST_F(TiltTest, ANaNWrenchStaysOne) {
  const Instance instance("tilt_allocation", world);
  for (const double x : control(instance, {0, kNan, 20, 0, 0, 0})) EXPECT_TRUE(is_nan(x));
}

TEST_F(TiltTest, GiveTheBitsOfDouble) {
  PluginWorld other = world;
  expect_same_bits("tilt_allocation", world);
  expect_same_bits("full_pose", other);
}

TEST_F(TiltTest, BadConfigurationNamesValueAndRemedy) {
  PluginWorld quad;
  quad.add_quad("quad");
  EXPECT_THAT(
      refusal("tilt_allocation", quad, {}),
      HasSubstr("rotor `rotor0` sits on `base`, which no revolute joint turns on the base"));
  PluginWorld off = world;
  off.rotors[0].position[1] = 0.01;
  EXPECT_THAT(refusal("tilt_allocation", off, {}),
              HasSubstr("rotor `rotor0` pushes 0.01 m beside the axis of joint `arm0_tilt`"));
  PluginWorld two = world;
  two.rotors.resize(4);
  two.robots[0].rotor_count = 4;
  EXPECT_THAT(refusal("tilt_allocation", two, {}),
              HasSubstr("the arms of robot `omav` cannot give"));
  EXPECT_THAT(refusal("full_pose", world, {{"position_min", std::vector<double>{6, 0, 0}}}),
              HasSubstr("`position_min[0]` 6 is not below `position_max[0]` 5"));
}

}  // namespace
}  // namespace skybody::testing
