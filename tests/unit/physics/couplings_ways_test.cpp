// Couplings by the tree's algorithms and by Simbody's own constraints, and in packs.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/unit/physics/coupled_worlds.h"
#include "tests/unit/physics/random_trees.h"
#include "tests/unit/physics/two_ways.h"

namespace skybody::test {
namespace {

CouplingEnd random_end(Random<double>& random, const std::vector<RobotUse>& robots, int robot) {
  const auto bodies = robots[static_cast<std::size_t>(robot)].model.bodies.size();
  return {robot, static_cast<int>(random.uniform() * static_cast<double>(bodies)),
          in_cube(random, 0.5)};
}

/// Two random trees with two to four couplings to each other and to the world.
Scenario joined_trees(Random<double>& random) {
  std::vector<RobotUse> robots;
  for (const char* name : {"a", "b"}) robots.push_back(make_robot(name, random_tree(random), {}));
  Scenario scenario;
  scenario.stepping.integrator = IntegratorChoice::kMidpoint;
  scenario.contact.ground = false;
  scenario.robots = robots;
  const int count = 2 + static_cast<int>(random.uniform() * 3.0);
  for (int i = 0; i < count; ++i) {
    const double draw = random.uniform();
    const CouplingKind kind = draw < 0.3   ? CouplingKind::kRod
                              : draw < 0.6 ? CouplingKind::kRope
                              : draw < 0.8 ? CouplingKind::kPoint
                                           : CouplingKind::kSpring;
    const CouplingEnd first = random_end(random, robots, 0);
    const CouplingEnd second = random.uniform() < 0.8 ? random_end(random, robots, 1)
                                                      : CouplingEnd{-1, 0, in_cube(random, 1.0)};
    Coupling coupling = make_coupling("c" + std::to_string(i), kind, first, second);
    coupling.constants[kCouplingLength] = random.uniform(0.3, 2.0);
    coupling.constants[kCouplingStiffness] = 100.0;
    coupling.constants[kCouplingDamping] = 1.0;
    scenario.couplings.push_back(coupling);
  }
  return scenario;
}

/// Sets the lengths of rods and ropes to the distances of their ends.
void fit_lengths(Bench& bench) {
  bench.stepper->update_bodies(bench.state);
  for (std::size_t i = 0; i < bench.world.scenario.couplings.size(); ++i) {
    const Coupling& coupling = bench.world.scenario.couplings[i];
    if (coupling.kind == CouplingKind::kPoint || coupling.kind == CouplingKind::kSpring) continue;
    bench.param("couplings." + coupling.name + ".length") = distance_of(bench, static_cast<int>(i));
  }
}

/// A length of no rod: update_bodies() must not move anything before lengths are fitted.
void part_all(Bench& bench, double present) {
  for (const Coupling& coupling : bench.world.scenario.couplings) {
    bench.param("couplings." + coupling.name + ".present") = present;
  }
}

class CouplingsOnBothDynamicsInBlocks : public testing::TestWithParam<int> {};

/// 200,000 states are drawn in all the blocks. About a third have points that cannot meet.
TEST_P(CouplingsOnBothDynamicsInBlocks, GiveTheSameAccelerations) {
  int compared = 0, nearly_singular = 0;
  for (std::uint64_t k = 0; k < 100; ++k) {
    Random<double> random{RandomKey{2026, 72}, k, static_cast<std::uint64_t>(GetParam()),
                          derive_stream("coupling_ways_test")};
    Bench bench(joined_trees(random));
    const auto simbody = make_simbody_stepper(bench.world);
    std::vector<double> by_tree(bench.state.u.size()), by_simbody(bench.state.u.size()), place;
    for (int i = 0; i < 250; ++i) {
      random_state(random, bench.world, bench.state.q, bench.state.u);
      // A change of lengths makes Simbody rebuild its system, so each configuration gets several
      // motions.
      if (i % 10 == 0) {
        part_all(bench, 0.0);
        fit_lengths(bench);
        part_all(bench, 1.0);
        place = bench.state.q;
      }
      bench.state.q = place;
      bench.stepper->update_bodies(bench.state);
      if (!bench.stepper->advance(bench.state)) continue;  // points that cannot meet
      bench.stepper->accelerations(bench.state, by_tree.data());
      simbody->accelerations(bench.state, by_simbody.data());
      ++compared;
      const double scale = 1.0 + largest(by_tree);
      double apart = 0.0;
      for (std::size_t n = 0; n < by_tree.size(); ++n) {
        apart = std::fmax(apart, std::fabs(by_tree[n] - by_simbody[n]) / scale);
      }
      // Masses of 10 g to 50 kg on almost redundant couplings: the nearly singular system amplifies
      // rounding in both.
      ASSERT_LT(apart, 1e-3) << k << ' ' << i;
      nearly_singular += apart > 1e-7;
    }
  }
  EXPECT_GT(compared, 12'500);  // 10^5 in all
  EXPECT_LT(nearly_singular, compared / 1000);
}

INSTANTIATE_TEST_SUITE_P(Blocks, CouplingsOnBothDynamicsInBlocks, testing::Range(0, 8));

TEST(CouplingsOnBothDynamics, FlyTheSameWay) {
  int compared = 0;
  for (std::uint64_t k = 0; k < 60; ++k) {
    Random<double> random{RandomKey{2026, 73}, k, 0, derive_stream("coupling_ways_test")};
    Bench bench(joined_trees(random));
    random_state(random, bench.world, bench.state.q, bench.state.u);
    for (double& u : bench.state.u) u *= 0.1;
    part_all(bench, 0.0);
    fit_lengths(bench);
    part_all(bench, 1.0);
    LaneState other = bench.state;
    const auto simbody = make_simbody_stepper(bench.world);
    bool through = true;
    for (int i = 0; i < 20 && through; ++i) {
      through = bench.stepper->advance(bench.state) && simbody->advance(other);
    }
    if (!through || largest(other.u) > 30.0) continue;  // rounding separates fast motions
    ++compared;
    for (std::size_t n = 0; n < other.u.size(); ++n) {
      // Each step distributes gaps of a micron: Simbody weights coordinates equally, ours weights
      // by mass.
      ASSERT_NEAR(bench.state.u[n], other.u[n], 2e-3) << k << ' ' << n;
    }
  }
  EXPECT_GT(compared, 20);
}

TEST(CouplingsInPacks, HaveTheBitsOfOneAlone) {
  for (std::uint64_t k = 0; k < 20; ++k) {
    Random<double> random{RandomKey{2026, 74}, k, 0, derive_stream("coupling_ways_test")};
    Bench bench(joined_trees(random));
    TwoWays ways(bench.world);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      random_state(random, bench.world, bench.state.q, bench.state.u);
      part_all(bench, 0.0);
      fit_lengths(bench);
      part_all(bench, lane % 5 == 0 ? 0.0 : 1.0);
      ways.set(lane, bench.state);
    }
    const std::uint32_t lanes = k % 2 == 0 ? 0xffffffffu : 0x5a5a1234u;
    ways.refresh(0xffffffffu);
    std::uint32_t through = lanes;
    for (int i = 0; i < 20; ++i) {
      through = ways.advance(through, "world " + std::to_string(k) + ", step " + std::to_string(i));
    }
  }
}

/// Two independent teams: in some lanes the first touches the ground, in some the second, in some
/// none.
TEST(CouplingsInPacks, OfSeveralTeamsHaveTheBitsOfOneAloneInContact) {
  std::vector<RobotUse> robots;
  for (const char* name : {"a", "b", "c", "d"}) {
    robots.push_back(make_robot(name, make_mass(0.5, 0.1), {}));
    robots.back().model.bodies[0].collisions = {make_sphere(0.1)};
    robots.back().pose.position = {0.6 * static_cast<double>(robots.size()), 0.0, 1.0};
  }
  Scenario scenario =
      make_team(robots, {make_coupling("rod", CouplingKind::kRod, {0, 0, {0, 0, 0}}, {1, 0, {}}),
                         make_coupling("rope", CouplingKind::kRope, {2, 0, {}}, {3, 0, {}})});
  scenario.contact.ground = true;
  Bench bench(scenario);
  TwoWays ways(bench.world);
  Random<double> random{RandomKey{2026, 75}, 0, 0, derive_stream("coupling_ways_test")};
  for (int lane = 0; lane < kGroupLanes; ++lane) {
    for (std::size_t robot = 0; robot < 4; ++robot) {
      const bool is_low = ((lane >> (robot / 2)) & 1) != 0;
      bench.state.q[7 * robot + 2] = (is_low ? 0.15 : 1.5) + random.uniform(0.0, 0.2);
    }
    for (double& u : bench.state.u) u = random.uniform(-2.0, 2.0);
    ways.set(lane, bench.state);
  }
  ways.refresh(0xffffffffu);
  std::uint32_t through = 0xffffffffu;
  for (int i = 0; i < 150; ++i) through = ways.advance(through, "step " + std::to_string(i));
  EXPECT_EQ(through, 0xffffffffu);
}

}  // namespace
}  // namespace skybody::test
