// Rank of the couplings' rows: redundant rows have a pivot of round-off only, for any masses of the
// other bodies.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/math/random.h"
#include "tests/unit/physics/coupled_worlds.h"
#include "tests/unit/physics/random_trees.h"

namespace skybody::test {
namespace {

constexpr CouplingEnd kAbove{-1, 0, {0, 0, 1}};

/// The force on the second end in the last step, W [N].
Vec3<double> pull_of(const Bench& bench, std::size_t coupling) {
  const double* pull = bench.state.coupling_forces.data() + 3 * coupling;
  return {-pull[0], -pull[1], -pull[2]};
}

/// At the far end of a light body a unit force has 1e11 times its effect on a tonne.
TEST(CouplingRank, HoldsATonneBesideTheFarEndOfAGram) {
  const RobotUse light = make_robot("light", make_mass(1e-3, 1e-3), {5, 0, 0}),
                 heavy = make_robot("heavy", make_mass(1e3, 0.5), {0, 0, 0});
  const Coupling far_rod =
      make_coupling("far_rod", CouplingKind::kRod, {-1, 0, {5.5, 0.3, 1}}, {0, 0, {0.5, 0.3, 0}});
  const Coupling chain = make_coupling("chain", CouplingKind::kRod, kAbove, {1, 0, {0, 0, 0}});
  Bench bench(make_team({light, heavy}, {far_rod, chain}));
  std::vector<double> udot(bench.state.u.size());
  bench.stepper->accelerations(bench.state, udot.data());
  EXPECT_NEAR(udot[8], 0.0, 1e-9) << "the tonne hangs";
  ASSERT_TRUE(bench.run(100));
  EXPECT_NEAR(pull_of(bench, 1).z, 9810.0, 1e-3);
  EXPECT_NEAR(distance_of(bench, 1), 1.0, 1e-9);
}

TEST(CouplingRank, HoldsWhatALightLinkOfATonneIsTiedTo) {
  RobotModel arm = make_free_body(1e3, diagonal(50, 50, 50));
  arm.bodies.push_back(
      make_body("link", JointType::kPin, 0, 1e-3, {0.05, 0, 0}, diagonal(1e-8, 1e-6, 1e-6)));
  const Scenario scenario = make_team(
      {make_robot("arm", arm, {0, 0, 0}), make_robot("ball", make_mass(0.1), {0.1, 0, 0})},
      {make_coupling("tip", CouplingKind::kPoint, {0, 1, {0.1, 0, 0}}, {1, 0, {}}),
       make_coupling("chain", CouplingKind::kRod, kAbove, {0, 0, {0, 0, 0}}),
       make_coupling("again", CouplingKind::kRod, kAbove, {0, 0, {0, 0, 0}})});
  Bench bench(scenario);
  for (int k = 0; k < 500; ++k) {
    ASSERT_TRUE(bench.run(1)) << k;
    ASSERT_LT(distance_of(bench, 0), 1e-9);
    ASSERT_NEAR(distance_of(bench, 1), 1.0, 1e-9);
  }
}

/// A closed planar linkage, anywhere in space: one of its point's three rows is redundant, in a
/// direction along no axis.
TEST(CouplingRank, ClosesAPlanarLoopInAnyPlane) {
  const auto link = [](const std::string& name, int parent, double length, double mass, double at,
                       double angle) {
    Body body = make_body(name, JointType::kPin, parent, mass, {0.5 * length, 0, 0},
                          diagonal(1e-4 * mass, 0.1 * mass * length, 0.1 * mass * length));
    body.joint.frame_in_parent.position = {at, 0, 0};
    body.joint.position = angle;
    return body;
  };
  const double along = (0.25 - 0.16 + 0.09) / 0.6, across = std::sqrt(0.25 - along * along);
  for (std::uint64_t k = 0; k < 60; ++k) {
    Random<double> random{RandomKey{2026, 76}, k, 0, derive_stream("coupling_rank_test")};
    const auto mass = [&] { return std::pow(10.0, random.uniform(-3.0, 3.0)); };
    RobotModel loop = make_free_body(mass(), diagonal(0.1, 0.1, 0.1));
    loop.fixed_base = false;
    loop.bodies.push_back(link("crank", 0, 0.2, mass(), 0.0, 0.0));
    loop.bodies.push_back(link("coupler", 1, 0.5, mass(), 0.2, std::atan2(across, along)));
    loop.bodies.push_back(link("rocker", 0, 0.4, mass(), 0.5, std::atan2(across, along - 0.3)));
    RobotUse robot = make_robot("loop", loop, {0, 0, 0});
    // The first planes are almost parallel to the axes.
    const double tilt = k < 20 ? std::pow(10.0, -static_cast<double>(k)) : 3.0;
    robot.pose.rotation = from_axis_angle(random.unit_vector(), tilt);
    Bench bench(make_team({robot}, {make_coupling("pin", CouplingKind::kPoint, {0, 2, {0.5, 0, 0}},
                                                  {0, 3, {0.4, 0, 0}})}));
    bench.state.u[6] = 1.0;
    bench.stepper->update_bodies(bench.state);
    for (int i = 0; i < 200; ++i) {
      ASSERT_TRUE(bench.run(1)) << k << ' ' << i;
      ASSERT_LT(distance_of(bench), 1e-9) << k << ' ' << i;
      // No force acts out of the plane: the linkage falls as one body.
      ASSERT_LT(norm(pull_of(bench, 0)), 1e5) << k << ' ' << i;
    }
  }
}

TEST(CouplingRank, IsTheSameHoweverOftenAThingIsSaid) {
  for (std::uint64_t k = 0; k < 100; ++k) {
    Random<double> random{RandomKey{2026, 77}, k, 0, derive_stream("coupling_rank_test")};
    const auto mass = [&] { return std::pow(10.0, random.uniform(-3.0, 3.0)); };
    const Scenario once = make_team(
        {make_robot("a", make_mass(mass(), 0.3), {0, 0, 0}),
         make_robot("b", make_mass(mass(), 0.3), {1, 0, 0})},
        {make_coupling("rod", CouplingKind::kRod, {0, 0, in_cube(random, 0.2)},
                       {1, 0, in_cube(random, 0.2)}),
         make_coupling("hook", CouplingKind::kPoint, {0, 0, {0, 0.1, 0}}, {-1, 0, {0, 0.1, 0}})});
    Scenario often = once;
    for (int copy = 0; copy < 3; ++copy) {
      for (const Coupling& coupling : once.couplings) {
        often.couplings.push_back(coupling);
        often.couplings.back().name += std::to_string(copy);
      }
    }
    Bench a(once), b(often);
    std::vector<double> of_once(12), of_often(12);
    a.stepper->accelerations(a.state, of_once.data());
    b.stepper->accelerations(b.state, of_often.data());
    for (std::size_t i = 0; i < 12; ++i) {
      ASSERT_NEAR(of_once[i], of_often[i], 1e-8 * (1.0 + std::fabs(of_once[i]))) << k;
    }
  }
}

/// Alternating links of a gram and of ten kilograms: the top one carries all.
TEST(CouplingRank, CarriesAChainOfLightAndHeavyLinks) {
  constexpr int kLinks = 20;
  std::vector<RobotUse> robots;
  std::vector<Coupling> couplings;
  double weight = 0.0;
  for (int i = 0; i < kLinks; ++i) {
    const double mass = i % 2 == 0 ? 1e-3 : 10.0;
    weight += 9.81 * mass;
    const double z = -0.1 * i - 0.05;
    robots.push_back(make_robot("link" + std::to_string(i), make_mass(mass, 0.03), {0, 0, z}));
    const CouplingEnd above =
        i == 0 ? CouplingEnd{-1, 0, {0, 0, 0}} : CouplingEnd{i - 1, 0, {0, 0, -0.05}};
    couplings.push_back(make_coupling("pin" + std::to_string(i), CouplingKind::kPoint, above,
                                      {i, 0, {0, 0, 0.05}}));
  }
  Bench bench(make_team(robots, couplings));
  ASSERT_TRUE(bench.run(20));
  EXPECT_NEAR(pull_of(bench, 0).z, weight, 1e-6 * weight);
  bench.state.u[6 * (kLinks - 1)] = 1.0;  // and it swings
  for (int i = 0; i < 300; ++i) {
    ASSERT_TRUE(bench.run(1)) << i;
    for (int c = 0; c < kLinks; ++c) ASSERT_LT(distance_of(bench, c), 1e-9) << i << ' ' << c;
  }
}

}  // namespace
}  // namespace skybody::test
