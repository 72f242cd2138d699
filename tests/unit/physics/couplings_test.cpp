// Rods, ropes, points and springs: closed forms, energy, momentum, drift.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/math/random.h"
#include "core/model/located_error.h"
#include "core/physics/bodies/kinematics.h"
#include "tests/unit/physics/coupled_worlds.h"

namespace skybody::test {
namespace {

constexpr CouplingEnd kOrigin{-1, 0, {0, 0, 0}};

/// A mass coupled to the world's origin, a metre below or beside it.
Scenario hanging(CouplingKind kind, Vec3<double> at,
                 IntegratorChoice integrator = IntegratorChoice::kMidpoint) {
  return make_team({make_robot("bob", make_mass(0.5), at)},
                   {make_coupling("line", kind, kOrigin, {0, 0, {0, 0, 0}})}, integrator);
}

TEST(Rod, KeepsItsLengthAndTheEnergyOfASwing) {
  for (const IntegratorChoice integrator :
       {IntegratorChoice::kMidpoint, IntegratorChoice::kSemiImplicitEuler, IntegratorChoice::kRk4,
        IntegratorChoice::kCvode}) {
    Bench bench(hanging(CouplingKind::kRod, {1, 0, 0}, integrator));
    const double before = mechanical_energy(bench);
    const bool is_euler = integrator == IntegratorChoice::kSemiImplicitEuler;
    const double seconds = is_euler || integrator == IntegratorChoice::kCvode ? 5.0 : 60.0;
    for (int second = 0; second < seconds; ++second) {
      ASSERT_TRUE(bench.run_seconds(1.0));
      ASSERT_NEAR(distance_of(bench), 1.0, 1e-9);  // gaps below 1e-10 count as closed
      // The bob falls by a metre: 4.9 J. First order: the integrator's own error.
      const double most = is_euler ? 0.05 : 1e-3;
      ASSERT_NEAR(mechanical_energy(bench), before, most * 4.905) << static_cast<int>(integrator);
    }
  }
}

TEST(Rod, SwingsAsAPendulumDoes) {
  // The period at an amplitude of 90 degrees: 4 K(sin(45 deg)) sqrt(l / g).
  const double period = 4.0 * 1.8540746773013719 * std::sqrt(1.0 / 9.81);
  Bench bench(hanging(CouplingKind::kRod, {1, 0, 0}));
  const auto times = upward_crossings(
      bench, [&] { return bench.state.bodies[0].position.x; }, 20000);
  EXPECT_NEAR(mean_period(times), period, 1e-5);
}

TEST(Rod, PullsAsHardAsAMassIsHeavyAndTurns) {
  Bench bench(hanging(CouplingKind::kRod, {0, 0, -1}));
  bench.state.u[0] = 2.0;
  ASSERT_TRUE(bench.run(1));
  // m (g + v^2 / l) on the first end, the world's; the bob moves by 2 mm per step.
  EXPECT_NEAR(bench.state.coupling_forces[2], -0.5 * (9.81 + 4.0), 1e-3);
  EXPECT_NEAR(bench.state.coupling_forces[0], 0.0, 0.05);
}

TEST(Rod, OfTwoRobotsKeepsTheirMomentum) {
  Scenario scenario = make_team(
      {make_robot("a", make_mass(0.5), {0, 0, 0}), make_robot("b", make_mass(2.0), {1, 0, 0})},
      {make_coupling("rod", CouplingKind::kRod, {0, 0, {0.1, 0, 0}}, {1, 0, {-0.1, 0.2, 0}})});
  scenario.constants[kGravity + 2] = 0.0;
  Bench bench(scenario);
  for (double& u : bench.state.u) u = 1.0;
  bench.state.u[7] = -3.0;
  bench.stepper->update_bodies(bench.state);
  const Momentum before = momentum(bench);
  const double energy = mechanical_energy(bench);
  ASSERT_TRUE(bench.run(5000));
  const Momentum after = momentum(bench);
  EXPECT_NEAR(norm(after.linear - before.linear), 0.0, 1e-11);
  // The step is of second order, and so is the error of the angular part.
  EXPECT_NEAR(norm(after.angular - before.angular), 0.0, 1e-4);
  EXPECT_NEAR(mechanical_energy(bench), energy, 1e-3 * energy);
}

TEST(Rope, CatchesWithoutALossOfMomentumNorAGainOfEnergy) {
  for (std::uint64_t k = 0; k < 200; ++k) {
    Random<double> random{RandomKey{2026, 71}, k, 0, derive_stream("coupling_test")};
    const auto in = [&](double most) { return random.uniform(-most, most); };
    Scenario scenario = make_team(
        {make_robot("a", make_mass(random.uniform(0.1, 2.0), 0.3), {0, 0, 0}),
         make_robot("b", make_mass(random.uniform(0.1, 2.0), 0.3), {0.5, 0, 0})},
        {with_length(make_coupling("rope", CouplingKind::kRope, {0, 0, {in(0.05), in(0.05), 0}},
                                   {1, 0, {in(0.05), in(0.05), in(0.05)}}),
                     1.0)});
    scenario.constants[kGravity + 2] = 0.0;
    Bench bench(scenario);
    for (double& u : bench.state.u) u = in(2.0);
    bench.state.u[0] = -random.uniform(0.5, 5.0);
    bench.state.u[6] = random.uniform(0.5, 5.0);
    bench.stepper->update_bodies(bench.state);
    const Momentum before = momentum(bench);
    double energy = mechanical_energy(bench);
    bool was_caught = false;
    for (int i = 0; i < 500; ++i) {
      const Vec3<double> turning = momentum(bench).angular;
      ASSERT_TRUE(bench.run(1));
      ASSERT_LE(distance_of(bench), 1.0 + 1e-9);
      const double now = mechanical_energy(bench);
      ASSERT_LE(now, energy * (1.0 + 1e-7)) << k << ' ' << i;  // error of the rotation itself
      if (now < 0.999 * energy) {
        was_caught = true;
        // After the impact the rest of the step is of second order: at most 3e-6, and above 1e-6 in
        // one of twenty.
        ASSERT_LT(norm(momentum(bench).angular - turning), 1e-5 * norm(turning)) << k << ' ' << i;
      }
      energy = now;
    }
    EXPECT_TRUE(was_caught) << k;
    const Momentum after = momentum(bench);
    ASSERT_NEAR(norm(after.linear - before.linear), 0.0, 1e-12);
    // Of steps while the rope is taut: of second order in dt.
    ASSERT_NEAR(norm(after.angular - before.angular), 0.0, 2e-3) << k;
  }
}

TEST(Rope, IsSlackUntilItIsLongEnoughAndNeverPushes) {
  Bench bench(make_team(
      {make_robot("bob", make_mass(1.0), {0, 0, -0.5})},
      {with_length(make_coupling("rope", CouplingKind::kRope, kOrigin, {0, 0, {0, 0, 0}}), 1.0)}));
  ASSERT_TRUE(bench.run_seconds(0.3));
  EXPECT_NEAR(bench.state.bodies[0].position.z, -0.5 - 0.5 * 9.81 * 0.09, 1e-6);
  EXPECT_EQ(bench.state.coupling_forces[2], 0.0);
  ASSERT_TRUE(bench.run_seconds(0.7));
  EXPECT_NEAR(bench.state.bodies[0].position.z, -1.0, 1e-9);
  EXPECT_NEAR(bench.state.coupling_forces[2], -9.81, 1e-6);
  bench.state.u[2] = 3.0;  // thrown up: slack
  ASSERT_TRUE(bench.run_seconds(0.2));
  EXPECT_NEAR(bench.state.bodies[0].position.z, -1.0 + 0.6 - 0.5 * 9.81 * 0.04, 1e-6);
  EXPECT_EQ(bench.state.coupling_forces[2], 0.0);
}

/// A bob thrown on a circle, too slow for the top, leaves the circle where the rope would have to
/// push: cos(angle from the top) = (v0^2 - 2 g l) / (3 g l), v0 the speed below.
TEST(Rope, LetsGoOnACircleWhereItWouldHaveToPush) {
  Bench bench(hanging(CouplingKind::kRope, {0, 0, -1}));
  const double speed = std::sqrt(3.5 * 9.81);
  bench.state.u[0] = speed;
  double height = 0.0;
  for (int i = 0; i < 2000 && (i < 2 || bench.state.coupling_forces[0] != 0.0 ||
                               bench.state.coupling_forces[2] != 0.0);
       ++i) {
    ASSERT_TRUE(bench.run(1));
    height = bench.state.bodies[0].position.z;
  }
  EXPECT_NEAR(height, (speed * speed - 2.0 * 9.81) / (3.0 * 9.81),
              2e-3);  // the bob moves by 2 mm per step
}

TEST(Point, HoldsAThingAsABallJointDoes) {
  // A rod of 1 m on a point of the world, against the same on a ball joint.
  RobotModel rod = make_free_body(0.6, diagonal(0.05, 0.05, 1e-4));
  RobotModel jointed = rod;
  jointed.bodies[0].joint.type = JointType::kBall;
  jointed.bodies[0].joint.frame_in_body.position = {0, 0, 0.5};
  Bench held(
      make_team({make_robot("rod", rod, {0, 0, -0.5})},
                {make_coupling("hook", CouplingKind::kPoint, {0, 0, {0, 0, 0.5}}, kOrigin)}));
  Bench ball(make_team({make_robot("rod", jointed, {0, 0, 0})}, {}));
  const Vec3<double> spin{2.0, -1.0, 3.0};
  store(spin, ball.state.u.data());
  store(spin, held.state.u.data() + 3);
  store(cross(spin, Vec3<double>{0, 0, -0.5}), held.state.u.data());
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(held.run_seconds(1.0));
    ASSERT_TRUE(ball.run_seconds(1.0));
    EXPECT_LT(norm(held.state.bodies[0].position - ball.state.bodies[0].position), 2e-5);
  }
}

/// A crank of 0.2 m on the world drives, by a coupler of 0.5 m, a rocker of 0.4 m whose joint is
/// 0.5 m away. The loop's closed form gives the rocker's angle for every angle of the crank.
TEST(Point, ClosesAFourBarLinkage) {
  const auto link = [](const std::string& name, int parent, double length, Vec3<double> at,
                       double angle) {
    Body body = make_body(name, JointType::kPin, parent, 0.3, {0.5 * length, 0, 0},
                          diagonal(1e-4, 0.01 * length, 0.01 * length));
    body.joint.frame_in_parent.position = at;
    body.joint.position = angle;
    return body;
  };
  // At the start the crank points along x; the triangle (0.2, 0), (0.5, 0) with 0.5 and 0.4.
  const double along = (0.25 - 0.16 + 0.09) / 0.6, across = std::sqrt(0.25 - along * along);
  RobotModel arm;
  arm.name = "arm";
  arm.fixed_base = true;
  arm.bodies = {link("crank", -1, 0.2, {0, 0, 0}, 0.0),
                link("coupler", 0, 0.5, {0.2, 0, 0}, std::atan2(across, along))};
  RobotModel rocker;
  rocker.name = "rocker";
  rocker.fixed_base = true;
  rocker.bodies = {link("rocker", -1, 0.4, {0.5, 0, 0}, std::atan2(across, along - 0.3))};
  Bench bench(make_team(
      {make_robot("arm", arm, {0, 0, 0}), make_robot("rocker", rocker, {0, 0, 0})},
      {make_coupling("pin", CouplingKind::kPoint, {0, 1, {0.5, 0, 0}}, {1, 0, {0.4, 0, 0}})}));
  bench.state.u[0] = 8.0;
  bench.stepper->update_bodies(bench.state);  // the others follow
  double energy = mechanical_energy(bench);
  for (int i = 0; i < 100000; ++i) {
    ASSERT_TRUE(bench.run(1));
    const double crank = bench.state.q[0], rock = bench.state.q[2];
    const double x = 0.5 + 0.4 * std::cos(rock) - 0.2 * std::cos(crank);
    const double y = 0.4 * std::sin(rock) - 0.2 * std::sin(crank);
    ASSERT_NEAR(std::hypot(x, y), 0.5, 1e-9) << i;
    ASSERT_LT(distance_of(bench), 1e-9);
  }
  EXPECT_NEAR(mechanical_energy(bench), energy, 1e-3 * energy);
}

TEST(Spring, SwingsAtItsFrequencyAndIsDamped) {
  Scenario scenario = make_team(
      {make_robot("a", make_mass(1.0), {0, 0, 0}), make_robot("b", make_mass(3.0), {1.2, 0, 0})},
      {with_length(
          make_coupling("spring", CouplingKind::kSpring, {0, 0, {0, 0, 0}}, {1, 0, {0, 0, 0}}),
          1.0)});
  scenario.constants[kGravity + 2] = 0.0;
  scenario.couplings[0].constants[kCouplingStiffness] = 300.0;
  Bench bench(scenario);
  const auto stretch = [&] { return distance_of(bench) - 1.0; };
  const double reduced = 0.75;
  EXPECT_NEAR(mean_period(upward_crossings(bench, stretch, 5000)),
              kTwoPi * std::sqrt(reduced / 300.0), 1e-5);
  bench.param("couplings.spring.damping") = 6.0;
  write_default_state(bench.world, bench.state);
  bench.param("couplings.spring.damping") = 6.0;
  ASSERT_TRUE(bench.run_seconds(1.0));
  const double decay = 6.0 / (2.0 * reduced), swing = std::sqrt(300.0 / reduced - decay * decay);
  EXPECT_NEAR(stretch(),
              0.2 * std::exp(-decay) * (std::cos(swing) + decay / swing * std::sin(swing)), 2e-6);
}

TEST(Coupling, ThatIsSaidTwiceChangesNothing) {
  Scenario once = make_team(
      {make_robot("a", make_mass(0.5), {0, 0, 0}), make_robot("b", make_mass(2.0), {1, 0, 0})},
      {make_coupling("rod", CouplingKind::kRod, {0, 0, {0.1, 0, 0}}, {1, 0, {-0.1, 0.2, 0}}),
       make_coupling("hook", CouplingKind::kPoint, {0, 0, {0, 0.1, 0}}, {-1, 0, {0, 0.1, 0}})});
  Scenario twice = once;
  for (const Coupling& coupling : once.couplings) {
    twice.couplings.push_back(coupling);
    twice.couplings.back().name += "_again";
  }
  Bench a(once), b(twice);
  for (Bench* bench : {&a, &b}) {
    for (double& u : bench->state.u) u = 0.7;
  }
  std::vector<double> of_once(12), of_twice(12);
  a.stepper->accelerations(a.state, of_once.data());
  b.stepper->accelerations(b.state, of_twice.data());
  for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(of_once[i], of_twice[i], 1e-10);
  ASSERT_TRUE(a.run(1000) && b.run(1000));
  for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(a.state.u[i], b.state.u[i], 1e-7);
}

/// A swinging chain from the world: a point, then a rod. Each coupling is declared once, and in a
/// second run twice: then four of the eight rows are redundant.
TEST(Coupling, DoesNotDriftInAHundredThousandSteps) {
  for (const bool is_doubled : {false, true}) {
    std::vector<Coupling> couplings{
        make_coupling("hook", CouplingKind::kPoint, {0, 0, {0, 0.1, 0.2}}, {-1, 0, {0, 0.1, 0.2}}),
        make_coupling("rod", CouplingKind::kRod, {0, 0, {0.1, 0, -0.2}}, {1, 0, {-0.1, 0.2, 0}})};
    for (int i = 0; is_doubled && i < 2; ++i) {
      couplings.push_back(couplings[static_cast<std::size_t>(i)]);
      couplings.back().name += "_again";
    }
    Bench bench(make_team({make_robot("a", make_mass(0.5, 0.2), {0, 0, 0}),
                           make_robot("b", make_mass(2.0, 0.1), {1, 0, 0})},
                          couplings));
    const double length = distance_of(bench, 1);
    for (int i = 0; i < 1000; ++i) {
      ASSERT_TRUE(bench.run(100));
      for (std::size_t c = 0; c < couplings.size(); ++c) {
        const double wanted = c % 2 == 0 ? 0.0 : length;
        // Gaps are closed to 1e-10 m after each step; the project's limit is 1e-6 m.
        ASSERT_NEAR(distance_of(bench, static_cast<int>(c)), wanted, 1e-9) << i << ' ' << c;
      }
    }
  }
}

TEST(Coupling, ThatIsSwitchedOffDoesNothing) {
  Bench bench(hanging(CouplingKind::kRod, {0, 0, -1}));
  bench.param("couplings.line.present") = 0.0;
  ASSERT_TRUE(bench.run_seconds(0.5));
  EXPECT_NEAR(bench.state.bodies[0].position.z, -1.0 - 0.5 * 9.81 * 0.25, 1e-9);
}

TEST(Coupling, BringsDrawnStartsTogetherOrFailsThere) {
  Bench bench(hanging(CouplingKind::kRod, {0, 0, -1}));
  bench.state.q[0] = 0.3;  // 1.044 m away
  bench.stepper->update_bodies(bench.state);
  EXPECT_NEAR(distance_of(bench), 1.0, 1e-9);
  const std::vector<double> q = bench.state.q, u = bench.state.u;
  bench.stepper->update_bodies(bench.state);
  EXPECT_EQ(bench.state.q, q);  // closed couplings do not change
  EXPECT_EQ(bench.state.u, u);
  // Two rods to the world that no position satisfies.
  Bench torn(
      make_team({make_robot("bob", make_mass(0.5), {0, 0, 0})},
                {make_coupling("a", CouplingKind::kRod, {0, 0, {0, 0, 0}}, {-1, 0, {1, 0, 0}}),
                 make_coupling("b", CouplingKind::kRod, {0, 0, {0, 0, 0}}, {-1, 0, {-1, 0, 0}})}));
  torn.param("couplings.a.length") = 0.2;
  torn.param("couplings.b.length") = 0.2;
  EXPECT_FALSE(torn.run(1));
}

TEST(Coupling, IsRefusedWhereItsEndsAreElsewhere) {
  const auto fitted = [](CouplingKind kind, double length, Vec3<double> at) {
    Coupling coupling = make_coupling("c", kind, kOrigin, {0, 0, {0, 0, 0}});
    if (length > 0.0) coupling = with_length(coupling, length);
    return make_team({make_robot("bob", make_mass(0.5), at)}, {coupling});
  };
  EXPECT_THROW(fitted(CouplingKind::kRope, 0.9, {0, 0, 1}), LocatedError);
  EXPECT_THROW(fitted(CouplingKind::kRod, 1.1, {0, 0, 1}), LocatedError);
  EXPECT_THROW(fitted(CouplingKind::kRod, 0.0, {0, 0, 0}), LocatedError);
  EXPECT_THROW(fitted(CouplingKind::kPoint, 0.0, {0, 0, 0.1}), LocatedError);
  EXPECT_NO_THROW(fitted(CouplingKind::kRope, 1.1, {0, 0, 1}));
  EXPECT_NO_THROW(fitted(CouplingKind::kSpring, 0.5, {0, 0, 1}));
}

/// The robot with a ball as its collision shape.
RobotUse with_ball(RobotUse use, double radius) {
  use.model.bodies[0].collisions = {make_sphere(radius)};
  return use;
}

TEST(Rope, GoesSlackWhereItsLoadIsSetDown) {
  // The upper mass falls slowly (a weak field): the lower one lands first, then the rope slackens.
  Scenario scenario =
      make_team({with_ball(make_robot("upper", make_mass(1.0, 0.1), {0, 0, 1.6}), 0.1),
                 with_ball(make_robot("lower", make_mass(1.0, 0.1), {0, 0, 0.6}), 0.1)},
                {make_coupling("rope", CouplingKind::kRope, {0, 0, {0, 0, 0}}, {1, 0, {0, 0, 0}})});
  scenario.contact.ground = true;
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(0.6));
  EXPECT_NEAR(bench.state.bodies[1].position.z, 0.1, 0.01);  // it lies on the ground
  EXPECT_LT(distance_of(bench), 0.9);                        // the upper one continues to fall
  EXPECT_EQ(bench.state.coupling_forces[2], 0.0);
}

TEST(Rod, DragsWhatHangsOnItWhereItIsHit) {
  // Two masses on a rod fly towards a wall, one behind the other: the second pushes the first.
  const auto fly = [](bool is_coupled) {
    Scenario scenario =
        make_team({with_ball(make_robot("first", make_mass(1.0, 0.1), {0, 0, 1}), 0.1),
                   with_ball(make_robot("second", make_mass(1.0, 0.1), {-1, 0, 1}), 0.1)},
                  {make_coupling("rod", CouplingKind::kRod, {0, 0, {0, 0, 0}}, {1, 0, {0, 0, 0}})});
    Obstacle wall{"wall", make_box(0.2, 4, 4)};
    wall.shape.pose.position = {0.6, 0, 1};
    scenario.obstacles = {wall};
    scenario.constants[kGravity + 2] = 0.0;
    auto bench = std::make_unique<Bench>(scenario);
    bench->param("couplings.rod.present") = is_coupled ? 1.0 : 0.0;
    bench->state.u[0] = bench->state.u[6] = 2.0;
    EXPECT_TRUE(bench->run_seconds(0.3));
    return bench;
  };
  const auto alone = fly(false), coupled = fly(true);
  EXPECT_LT(alone->state.u[0], 0.0);
  EXPECT_NEAR(alone->state.u[6], 2.0, 1e-12);
  EXPECT_NEAR(coupled->state.u[0], coupled->state.u[6], 1e-9);  // they rebound together
  EXPECT_LT(coupled->state.u[6], 0.0);
  EXPECT_NEAR(distance_of(*coupled), 1.0, 1e-9);
}

TEST(Couplings, KeepMomentumInAContactOfWhatTheyHold) {
  Scenario scenario =
      make_team({with_ball(make_robot("a", make_mass(1.0, 0.1), {0, 0, 1}), 0.1),
                 with_ball(make_robot("b", make_mass(0.7, 0.1), {0, 0.5, 1}), 0.1),
                 with_ball(make_robot("c", make_mass(0.4, 0.1), {0.5, 0.05, 1}), 0.1)},
                {make_coupling("rod", CouplingKind::kRod, {0, 0, {0, 0, 0}}, {1, 0, {0, 0, 0}})});
  scenario.constants[kGravity + 2] = 0.0;
  Bench bench(scenario);
  bench.state.u[12] = -2.0;
  bench.stepper->update_bodies(bench.state);
  const Momentum before = momentum(bench);
  const double energy = mechanical_energy(bench);
  ASSERT_TRUE(bench.run_seconds(0.4));
  EXPECT_GT(bench.state.u[12], -1.9);  // it has hit
  EXPECT_GT(norm(bench.state.bodies[1].velocity), 0.05);
  EXPECT_NEAR(norm(momentum(bench).linear - before.linear), 0.0, 1e-12);
  EXPECT_LT(mechanical_energy(bench), energy);
}

}  // namespace
}  // namespace skybody::test
