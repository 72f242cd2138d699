// joint_pd and arm on a vehicle with a planar arm of two links, by hand.
#include <cmath>

#include "core/base/math/quat.h"
#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using V = Vec3<double>;
using Q = Quat<double>;
using ::testing::HasSubstr;

constexpr double kUpper = 0.2, kFore = 0.15;  // lengths [m]

/// Shoulder and elbow turn about y of the vehicle; at 0 the arm hangs straight down.
class ArmTest : public ::testing::Test {
 protected:
  ArmTest() {
    world.add_quad("quad");
    upper = add_link("upper", 0, {0.0, 0.0, -0.1}, -kUpper / 2);
    fore = add_link("fore", upper, {0.0, 0.0, -kUpper}, -kFore / 2);
    g_q = {world.bodies[at(upper)].first_q, world.bodies[at(fore)].first_q};
  }
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  int add_link(const std::string& name, int parent, const V& hinge, double com) {
    const int body = world.add_body(0, name, parent, SKYBODY_PIN, 0.1, {2e-4, 3e-4, 1e-5});
    SkybodyBodyInfo& info = world.bodies.back();
    info.joint_name = world.keep(name + "_joint");
    info.com[2] = com;
    world.params[at(info.first_param + SKYBODY_BODY_COM + 2)].nominal = com;
    const double half = std::sqrt(0.5);  // z of the joint along y: -90 degrees about x
    const double in_parent[7] = {hinge.x, hinge.y, hinge.z, half, -half, 0.0, 0.0};
    const double in_body[7] = {0.0, 0.0, 0.0, half, -half, 0.0, 0.0};
    std::copy(in_parent, in_parent + 7, info.joint_in_parent);
    std::copy(in_body, in_body + 7, info.joint_in_body);
    return body;
  }

  /// Sets the poses of base and arm from joint angles.
  void pose(Group& g, const V& p, const Q& q, double shoulder, double elbow) const {
    const Q one = q * from_axis_angle(V{0, 1, 0}, shoulder);
    const Q two = one * from_axis_angle(V{0, 1, 0}, elbow);
    const V first = p + rotate(q, V{0, 0, -0.1}), second = first + rotate(one, V{0, 0, -kUpper});
    put(g, 0, p, q);
    put(g, upper, first, one);
    put(g, fore, second, two);
    g.at(g.q, g_q[0]) = shoulder;
    g.at(g.q, g_q[1]) = elbow;
  }
  static void put(Group& g, int body, const V& p, const Q& q) {
    const double values[7] = {p.x, p.y, p.z, q.w, q.x, q.y, q.z};
    for (int k = 0; k < 7; ++k) g.at(g.bodies, 13 * body + k) = values[k];
  }
  /// Tip of the arm in the frame of the base.
  static V tip(double shoulder, double elbow) {
    return {-kUpper * std::sin(shoulder) - kFore * std::sin(shoulder + elbow), 0.0,
            -0.1 - kUpper * std::cos(shoulder) - kFore * std::cos(shoulder + elbow)};
  }
  const std::vector<std::string> joints = {"upper_joint", "fore_joint"};
  Parameters arm(Parameters more = {}) const {
    more.emplace("joints", joints);
    more.emplace("link", "fore");
    more.emplace("point", std::vector<double>{0.0, 0.0, -kFore});
    return more;
  }

  PluginWorld world;
  int upper = 0, fore = 0;
  std::array<int, 2> g_q{};
};

TEST_F(ArmTest, JointPdMovesTheInertiaAndBearsTheWeightOfTheFoldedArm) {
  const Instance instance("joint_pd", world,
                          {{"joints", joints}, {"bandwidth", 10.0}, {"low", -3}, {"high", 3}});
  Group g = instance.group(1);
  const double s = 0.4, e = 0.9;
  pose(g, {0, 0, 2}, {1, 0, 0, 0}, s, e);
  g.at(g.u, world.bodies[at(fore)].first_u) = 0.5;
  g.input = {0.6, 0.9};
  instance.call(Call::kControl, g);
  // Centres of mass from each hinge, in the plane of x and z.
  const double x1 = -kUpper / 2 * std::sin(s), x2 = -kFore / 2 * std::sin(s + e);
  const double x12 = -kUpper * std::sin(s) + x2;
  const double z12 = -kUpper * std::cos(s) - kFore / 2 * std::cos(s + e);
  const double fore_inertia = 3e-4 + 0.1 * kFore * kFore / 4;
  const double all = 3e-4 + 0.1 * kUpper * kUpper / 4 + 3e-4 + 0.1 * (x12 * x12 + z12 * z12);
  // About y, a weight at x gives the torque x m g.
  EXPECT_NEAR(g.output[0], all * 100.0 * 0.2 - 0.1 * 9.81 * (x1 + x12), 1e-14);
  EXPECT_NEAR(g.output[1], fore_inertia * (-2.0 * 10.0 * 0.5) - 0.1 * 9.81 * x2, 1e-14);
  ASSERT_EQ(instance.declared.controller.joints.size(), 2u);
  EXPECT_EQ(instance.declared.controller.joints[0].mode, JointMode::kEffort);
}

TEST_F(ArmTest, JointPdFollowsDrawnConstantsWhereAsked) {
  PluginWorld other = world;
  const Parameters given = {{"joints", joints}, {"gravity", false}, {"low", -3}, {"high", 3}};
  const Instance nominal("joint_pd", world, given);
  Parameters own_given = given;
  own_given.emplace("constants", "own");
  const Instance own("joint_pd", other, own_given);
  const auto effort = [&](const Instance& instance) {
    Group g = instance.group(1);
    pose(g, {0, 0, 2}, {1, 0, 0, 0}, 0.0, 0.0);
    g.at(g.params, world.bodies[at(fore)].first_param) = 0.3;
    g.input = {0.0, 0.1};
    instance.call(Call::kControl, g);
    return g.output[1];
  };
  const double lever = kFore * kFore / 4;
  EXPECT_NEAR(effort(nominal), (3e-4 + 0.1 * lever) * 400.0 * 0.1, 1e-14);
  EXPECT_NEAR(effort(own), (3e-4 + 0.3 * lever) * 400.0 * 0.1, 1e-14);
}

TEST_F(ArmTest, ArmReachesAPlaceAndKeepsItWhileTheVehicleSways) {
  const Instance instance("arm", world, arm());
  Group g = instance.group(1);
  pose(g, {0, 0, 2}, {1, 0, 0, 0}, 0.3, 0.5);
  instance.call(Call::kReset, g);
  const V place = V{0, 0, 2} + tip(-0.7, 1.3);
  for (int n = 0; n < 2000; ++n) {
    const V p = {0.02 * std::sin(0.01 * n), 0.0, 2.0};
    const Q q = from_axis_angle(V{0, 1, 0}, 0.1 * std::sin(0.007 * n));
    pose(g, p, q, 0.3, 0.5);  // the joints' positions no longer matter
    g.input = {place.x, place.y, place.z, 1.0, 0.0, 0.0, 0.0};
    const std::vector<double> last = g.buffer;
    instance.call(Call::kControl, g);
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_LE(std::fabs(g.output[k] - last[k]), 0.003 * (1.0 + 1e-12));
    }
    if (n < 1000) continue;
    const V reached = p + rotate(q, tip(g.output[0], g.output[1]));
    // Each step leaves at most a hundredth of an error that grows by 0.3 mm.
    EXPECT_LT(norm(reached - place), 2e-4) << n;
  }
}

TEST_F(ArmTest, ArmStretchesTowardsWhatIsOutOfReachAndLooksWhereItShould) {
  const Instance instance("arm", world, arm({{"frame", "base"}}));
  Group g = instance.group(1);
  pose(g, {0, 0, 2}, {1, 0, 0, 0}, 0.3, 0.5);
  instance.call(Call::kReset, g);
  g.input = {1.0, 0.5, -1.1, 1.0, 0.0, 0.0, 0.0};
  for (int n = 0; n < 20000; ++n) instance.call(Call::kControl, g);
  // The nearest reachable point: on the circle of radius 0.35 m about the shoulder, towards (1,
  // -1).
  const V end = tip(g.output[0], g.output[1]);
  EXPECT_NEAR(end.x, 0.35 * std::sqrt(0.5), 1e-3);
  EXPECT_NEAR(end.z, -0.1 - 0.35 * std::sqrt(0.5), 1e-3);

  PluginWorld other = world;
  const Instance turner("arm", other, arm({{"frame", "base"}, {"orientation_weight", 100.0}}));
  Group h = turner.group(1);
  pose(h, {0, 0, 2}, {1, 0, 0, 0}, 0.3, 0.5);
  turner.call(Call::kReset, h);
  const Q setpoint = from_axis_angle(V{0, 1, 0}, 1.5);
  h.input = {0.0, 0.0, -0.3, setpoint.w, setpoint.x, setpoint.y, setpoint.z};
  for (int n = 0; n < 5000; ++n) turner.call(Call::kControl, h);
  EXPECT_NEAR(h.output[0] + h.output[1], 1.5, 1e-3);
}

TEST_F(ArmTest, ANaNPlaceIsPassedOnAndLeavesNoTrace) {
  const Instance instance("arm", world, arm());
  Group g = instance.group(1);
  pose(g, {0, 0, 2}, {1, 0, 0, 0}, 0.3, 0.5);
  instance.call(Call::kReset, g);
  const std::vector<double> before = g.buffer;
  g.input = {kNan, 0.0, 1.7, 1.0, 0.0, 0.0, 0.0};
  instance.call(Call::kControl, g);
  EXPECT_TRUE(is_nan(g.output[0]));
  EXPECT_EQ(g.buffer, before);
}

TEST_F(ArmTest, GiveTheBitsOfDouble) {
  PluginWorld second = world, third = world;
  expect_same_bits("arm", world, arm({{"orientation_weight", 0.1}}));
  expect_same_bits("joint_pd", second, {{"joints", joints}, {"low", -1}, {"high", 1}});
  expect_same_bits("joint_pd", third,
                   {{"joints", joints}, {"low", -1}, {"high", 1}, {"constants", "own"}});
}

TEST_F(ArmTest, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("joint_pd", world, {}), HasSubstr("`joints` names no joint to drive"));
  EXPECT_THAT(refusal("joint_pd", world, {{"joints", joints}}),
              HasSubstr("joint `upper_joint` has no range: give `low` and `high`"));
  EXPECT_THAT(
      refusal("joint_pd", world, {{"joints", joints}, {"bandwidth", std::vector<double>{1, 2, 3}}}),
      HasSubstr("`bandwidth` has 3 values, `joints` 2: give one for all, or one for each"));
  EXPECT_THAT(refusal("joint_pd", world, {{"joints", joints}, {"low", 2}, {"high", 1}}),
              HasSubstr("`low` 2 is not below `high` 1"));
  EXPECT_THAT(refusal("arm", world, {{"joints", joints}, {"link", "base"}}),
              HasSubstr("link `base` is part of the base: no joint moves it"));
  EXPECT_THAT(refusal("arm", world, {{"joints", joints}, {"link", "upper"}}),
              HasSubstr("in order: [upper_joint]"));
  EXPECT_THAT(refusal("arm", world, arm({{"place_min", std::vector<double>{2, 0, 0}}})),
              HasSubstr("`place_min[0]` 2 is not below `place_max[0]` 1"));
}

}  // namespace
}  // namespace skybody::testing
