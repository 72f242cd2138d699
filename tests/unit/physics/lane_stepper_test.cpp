// Wrenches, disturbances, drives, and guarantees of the stepper.
#include "core/physics/step/lane_stepper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <new>
#include <stdexcept>

#include "core/base/system/error.h"
#include "core/physics/bodies/kinematics.h"
#include "tests/unit/physics/test_models.h"
#include "tests/unit/physics/uncoupled_dynamics.h"

namespace skybody::test {
namespace {

constexpr auto kRk4 = IntegratorChoice::kRk4;

/// An off-centre body in space, rotated by a quarter turn about z: body x is world y.
Scenario turned_body() {
  Scenario scenario =
      make_scenario(make_free_body(2.0, diagonal(0.01, 0.02, 0.03), {0.1, 0.0, 0.0}));
  scenario.constants[kGravity + 2] = 0.0;
  scenario.robots[0].pose = {{0, 0, 5}, from_rpy(0.0, 0.0, kHalfPi)};
  return scenario;
}

/// Acceleration of the centre of mass [W] and angular acceleration [body axes], at rest.
struct Response {
  Vec3<double> linear, angular;
};
Response respond(Bench& bench) {
  std::vector<double> udot(6);
  bench.stepper->accelerations(bench.state, udot.data());
  const Vec3<double> angular = load_vec3(udot.data() + 3);
  const Vec3<double> com{bench.param("robots.r.links.base.com[0]"), 0, 0};
  return {load_vec3(udot.data()) + rotate(bench.state.bodies[0].rotation, cross(angular, com)),
          angular};
}

void expect_near(const Vec3<double>& a, const Vec3<double>& b) {
  EXPECT_LT(norm(a - b), 1e-12) << a.x << " " << a.y << " " << a.z;
}

TEST(Wrench, ActsAtItsPointInItsAxes) {
  struct Case {
    WrenchSite site;
    Vec3<double> linear, angular;
  };
  // Force (1, 2, 3) N, moment (0.1, 0.2, 0.3) N m; body x is world y, body y is world -x.
  const Case cases[] = {
      {{0, {0, 0, 0}, true, true}, {0.5, 1.0, 1.5}, {0.2 / 0.01, -0.1 / 0.02, 0.3 / 0.03}},
      {{0, {0, 0, 0}, true, false}, {-1.0, 0.5, 1.5}, {0.1 / 0.01, 0.2 / 0.02, 0.3 / 0.03}},
      // At (0.1, 0.4, 0), 0.4 m along body y from the centre of mass: moment (0.4 y) x F.
      {{0, {0.1, 0.4, 0}, false, false},
       {-1.0, 0.5, 1.5},
       {(0.1 + 1.2) / 0.01, 0.2 / 0.02, (0.3 - 0.4) / 0.03}},
  };
  for (const Case& c : cases) {
    Bench bench(turned_body(), [&](WorldPlan& plan) { plan.sites = {c.site}; });
    ASSERT_EQ(bench.world.layout.wrench.size, 6);
    bench.state.wrench = {1, 2, 3, 0.1, 0.2, 0.3};
    const Response r = respond(bench);
    expect_near(r.linear, c.linear);
    expect_near(r.angular, c.angular);
  }
}

TEST(Wrench, AtTheCentreOfMassFollowsADrawnCentreOfMass) {
  Bench bench(turned_body(), [](WorldPlan& plan) { plan.sites = {{0, {0, 0, 0}, true, true}}; });
  bench.state.wrench = {1, 2, 3, 0, 0, 0};
  bench.param("robots.r.links.base.com[0]") = -0.2;
  expect_near(respond(bench).angular, {0, 0, 0});
}

TEST(Disturbance, ForceIsInWorldAxesAndMomentInBaseAxes) {
  Scenario scenario = turned_body();
  scenario.robots[0].constants = {1, 2, 3, 0.1, 0.2, 0.3};
  Bench bench(std::move(scenario));
  const Response r = respond(bench);
  expect_near(r.linear, {0.5, 1.0, 1.5});
  expect_near(r.angular, {10.0, 10.0, 10.0});
  bench.param("robots.r.disturbance.force[0]") = 5.0;
  expect_near(respond(bench).linear, {2.5, 1.0, 1.5});
}

Scenario driven_payload() {
  RobotModel model = make_vehicle(qdrone2());
  model.bodies.push_back(
      make_body("bob", JointType::kPin, 0, 0.2, {0, -0.8, 0}, diagonal(1e-3, 1e-3, 1e-3)));
  model.bodies[1].joint.frame_in_parent.rotation = from_axis_angle(Vec3<double>{1, 0, 0}, kHalfPi);
  Scenario scenario = make_scenario(std::move(model), kRk4);
  scenario.robots[0].pose.position = {0, 0, 5};
  return scenario;
}

TEST(VelocityDrive, MovesTheBaseInItsOwnAxesAndLetsThePayloadSwing) {
  Scenario scenario = driven_payload();
  scenario.robots[0].pose.rotation = from_rpy(0.0, 0.0, kHalfPi);
  Bench bench(std::move(scenario), [](WorldPlan& plan) { plan.drives = {DriveKind::kVelocity}; });
  ASSERT_EQ(bench.world.layout.drive.size, 13);
  bench.state.drive[0] = 1.5;
  ASSERT_TRUE(bench.run(1000));
  // Forward is world y; no force moves or turns the base.
  EXPECT_NEAR(bench.state.q[1], 1.5, 1e-12);
  EXPECT_NEAR(bench.state.q[2], 5.0, 1e-12);
  EXPECT_NEAR(bench.state.u[1], 1.5, 1e-14);
  EXPECT_NEAR(bench.state.q[7], 0.0, 1e-15) << "steady motion leaves the payload hanging";

  bench.state.drive[0] = 0.0;
  bench.state.q[7] = -0.01;
  const double period = mean_period(upward_crossings(
      bench, [&] { return bench.state.q[7]; }, 8000));
  // A pendulum on a base that no reaction moves.
  EXPECT_NEAR(period, kTwoPi * std::sqrt((1e-3 + 0.2 * 0.64) / (0.2 * 9.81 * 0.8)), 1e-4);
}

TEST(VelocityDrive, TurnsTheBase) {
  Bench bench(driven_payload(), [](WorldPlan& plan) { plan.drives = {DriveKind::kVelocity}; });
  bench.state.drive[5] = 0.5;
  ASSERT_TRUE(bench.run(1000));
  // Each step turns by 2 atan(w h / 2) rather than w h: an error of at most (w h)^3 / 12 per step.
  EXPECT_NEAR(yaw(load_quat(bench.state.q.data() + 3)), 0.5, 1e-8);
}

TEST(PoseDrive, ReachesThePoseExactlyAtTheEndOfTheStep) {
  Bench bench(driven_payload(), [](WorldPlan& plan) { plan.drives = {DriveKind::kPose}; });
  const Quat<double> target = from_rpy(0.1, -0.2, 0.3);
  store(Vec3<double>{0.01, 0.02, 5.03}, bench.state.drive.data() + kDrivePosition);
  store(target, bench.state.drive.data() + kDriveRotation);
  ASSERT_TRUE(bench.run(1));
  const BodyState& base = bench.state.bodies[0];
  EXPECT_EQ(norm(base.position - Vec3<double>{0.01, 0.02, 5.03}), 0.0);
  EXPECT_NEAR(std::fabs((conjugate(target) * base.rotation).w), 1.0, 1e-14);
  EXPECT_NEAR(base.velocity.x, 10.0, 1e-12);
  ASSERT_TRUE(bench.run(1));
  EXPECT_LT(norm(bench.state.bodies[0].velocity), 1e-10) << "arrived";
}

bool same_bits(const LaneState& a, const LaneState& b) {
  const auto same = [](const std::vector<double>& x, const std::vector<double>& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(double)) == 0;
  };
  return same(a.q, b.q) && same(a.u, b.u) && same(a.rotor_speed, b.rotor_speed) &&
         std::memcmp(a.bodies.data(), b.bodies.data(), a.bodies.size() * sizeof(BodyState)) == 0;
}

Scenario payload_flight() {
  Scenario scenario = driven_payload();
  scenario.stepping.integrator = IntegratorChoice::kSemiImplicitEuler;
  scenario.robots[0].rotor_speed = -1.0;
  return scenario;
}

TEST(Stepper, DrawnParametersCountHoweverOftenTheyChange) {
  // The same values twice, with invalid ones and nominal ones in between: each state continues as
  // on a stepper without history.
  Bench bench(payload_flight());
  const std::vector<double> nominal = bench.state.params;
  std::vector<double> heavy = nominal, broken = nominal;
  heavy[static_cast<std::size_t>(bench.world.layout.body_params[0] + kMass)] *= 1.5;
  broken[static_cast<std::size_t>(bench.world.layout.body_params[0] + kMass)] = -1.0;
  const auto expect_fresh = [&](const std::vector<double>& params) {
    bench.state.params = params;
    LaneState alone = bench.state;
    const bool through = make_stepper(bench.world)->advance(alone);
    EXPECT_EQ(bench.stepper->advance(bench.state), through);
    EXPECT_TRUE(same_bits(bench.state, alone));
  };
  for (const auto& params :
       {nominal, heavy, heavy, broken, heavy, broken, nominal, heavy, nominal, broken, nominal}) {
    expect_fresh(params);
  }
}

TEST(Stepper, AfterAMassChangeIsTheSameAsAFreshWorldOfThatMass) {
  Scenario heavy = payload_flight();
  heavy.robots[0].model.bodies[0].mass.mass = 2.0;
  heavy.robots[0].model.bodies[1].mass.com.x = 0.05;
  Bench fresh(std::move(heavy));
  Bench changed(payload_flight());
  ASSERT_TRUE(changed.run(50));
  changed.state = fresh.state;  // including parameters
  ASSERT_TRUE(changed.run(200));
  ASSERT_TRUE(fresh.run(200));
  EXPECT_TRUE(same_bits(changed.state, fresh.state));
}

TEST(Stepper, ResultsDoNotDependOnWhatItSawBefore) {
  Bench a(payload_flight()), b(payload_flight());
  a.state.rotor_command.assign(4, 1500.0);
  ASSERT_TRUE(a.run(100));
  const LaneState saved = a.state;
  ASSERT_TRUE(a.run(100));
  // In between, b serves another environment, with other parameters, then a failing one.
  b.state.q[7] = 1.0;
  b.param("robots.r.links.base.mass") = 3.0;
  b.param("robots.r.rotors[0].tau_up") = 0.1;
  ASSERT_TRUE(b.run(37));
  b.state.u[0] = kNan;
  EXPECT_FALSE(b.run(1));
  b.state = saved;
  ASSERT_TRUE(b.run(100));
  EXPECT_TRUE(same_bits(a.state, b.state));
}

TEST(Stepper, NonFiniteStepReturnsFalseAndLeavesTheState) {
  for (const IntegratorChoice integrator : kFixedSteps) {
    Scenario scenario = payload_flight();
    scenario.stepping.integrator = integrator;
    Bench bench(std::move(scenario));
    ASSERT_TRUE(bench.run(10));
    const LaneState good = bench.state;
    bench.state.rotor_command[1] = kNan;
    EXPECT_FALSE(bench.run(1));
    EXPECT_TRUE(same_bits(bench.state, good));
    bench.state = good;
    bench.state.u[4] = kInfinity;
    EXPECT_FALSE(bench.run(1));
    bench.state = good;
    bench.state.u[4] = 1e200;  // finite, but not after a step
    EXPECT_FALSE(bench.run(1));
    bench.state = good;
    bench.state.u[4] = 2e6;  // [m/s]: diverged
    EXPECT_FALSE(bench.run(1));
    bench.state = good;
    bench.param("robots.r.links.base.mass") = -1.0;
    EXPECT_FALSE(bench.run(1)) << "masses that cannot be built are a failed step";
    EXPECT_EQ(bench.state.q, good.q);
    bench.state = good;
    EXPECT_TRUE(bench.run(10)) << "the stepper goes on with good states";
  }
}

/// Throws `Failure` from every evaluation.
template <class Failure>
class FailingDynamics final : public UncoupledDynamics {
 public:
  void set_params(const double*) override {}
  void accelerations(const double*, const double*, const SpatialForce<double>*, const double*,
                     double*) override {
    throw Failure();
  }
  void body_states(const double*, const double*, BodyState*) override {}
};

struct GivesUp : std::runtime_error {
  GivesUp() : std::runtime_error("singular") {}
};
struct Bug : std::logic_error {
  Bug() : std::logic_error("demanded") {}
};

template <class Failure>
bool advance_with_failure(Bench& bench) {
  const StepPlan plan(bench.world, DynamicsBackend::kSimbody);
  LaneStepper stepper(plan, std::make_unique<FailingDynamics<Failure>>());
  const GroupBlocks lane = Stepper::blocks(bench.state);
  return stepper.advance({&plan, &lane, nullptr, nullptr, nullptr});
}

TEST(Stepper, OnlyDynamicsThatGiveUpAreAFailedStep) {
  Bench bench(payload_flight());
  EXPECT_FALSE(advance_with_failure<GivesUp>(bench));
  EXPECT_THROW(advance_with_failure<Bug>(bench), std::logic_error);
  EXPECT_THROW(advance_with_failure<std::bad_alloc>(bench), std::bad_alloc);
}

TEST(World, FreeBaseHasThePlainFramesThatItsCoordinatesMean) {
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
  model.bodies[0].joint.frame_in_parent.position = {0, 0, 1};
  EXPECT_THROW(World(make_scenario(model)), std::logic_error);
  model.bodies[0].joint.frame_in_parent = Pose{};
  model.bodies[0].joint.frame_in_body.rotation = from_rpy(0.0, 0.0, 1.0);
  EXPECT_THROW(World(make_scenario(model)), std::logic_error);
  model.bodies[0].joint.frame_in_body = Pose{};
  EXPECT_NO_THROW(World(make_scenario(model)));
  model.bodies.push_back(model.bodies[0]);
  EXPECT_THROW(World(make_scenario(model)), std::logic_error) << "two bases";
}

TEST(Stepper, ImpossibleInertiaIsAnErrorThatNamesTheBody) {
  try {
    Bench bench(make_scenario(make_free_body(1.0, diagonal(0.01, 0.01, 0.03))));
    FAIL() << "built";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("'base'"), std::string::npos) << error.what();
  }
}

TEST(Stepper, AcceptsTheInertiaOfAFlatBodyWithinRounding) {
  Bench bench(make_scenario(make_free_body(1.0, diagonal(0.01, 0.02, 0.03 * (1 + 1e-9)))));
  EXPECT_TRUE(bench.run(10));
}

TEST(StateLayout, NamesEveryParameterAndOrdersTheBlocks) {
  Bench bench(payload_flight());
  const StateLayout& layout = bench.world.layout;
  EXPECT_EQ(layout.q.size, 8);
  EXPECT_EQ(layout.u.size, 7);
  EXPECT_EQ(layout.params.size, 2 * 10 + 4 * 11 + 6 + 3 + 5);
  EXPECT_EQ(layout.find_param("robots.r.links.bob.mass"), layout.body_params[1]);
  EXPECT_EQ(layout.find_param("robots.r.links.base.inertia[5]"), layout.body_params[0] + 9);
  EXPECT_EQ(layout.find_param("robots.r.rotors[2].tau_down"), layout.rotor_params[2] + kTauDown);
  EXPECT_EQ(layout.find_param("robots.r.disturbance.moment[0]"),
            layout.robot_params[0] + kDisturbanceMoment);
  EXPECT_EQ(layout.find_param("robots.r.links.rod.mass"), -1);
  EXPECT_EQ(layout.q.offset, kHeaderSize);
  EXPECT_EQ(layout.params.offset, layout.bristles.offset + layout.bristles.size);
  EXPECT_EQ(layout.words, layout.params.offset + layout.params.size);
}

}  // namespace
}  // namespace skybody::test
