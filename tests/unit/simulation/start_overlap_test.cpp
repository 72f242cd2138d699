// Starts with a robot inside another object are drawn again, and are a fault if they remain so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/batch/pool.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

using testing::HasSubstr;

/// Starts in a square of 4 m at a height of 1 m: seven of eight lie in the block.
const std::string kBlock = "obstacles=[{name: block, box: [3.8, 3.8, 2], position: [0, 0, 1]}]";
const std::string kStart =
    "{plugin: start, parameters: {position_min: [-2.5, -2.5, 1], position_max: [2.5, 2.5, 1]}}";

std::vector<std::string> with(const std::string& obstacles, const std::string& randomizers,
                              std::vector<std::string> more = {}) {
  more.insert(more.begin(), {obstacles, "randomization=[" + randomizers + "]",
                             "robots.quad.pose.position=[0, 0, 5]"});
  return more;
}

Simulation hover(const std::vector<std::string>& overrides, std::uint64_t env_id = 0) {
  return Simulation({.scenario = "hover", .overrides = overrides, .seed = 4, .env_id = env_id});
}

std::string reason(const Simulation& simulation) {
  return simulation.compiled().fault_reason(simulation.status());
}

/// Tests if the quadrotor, 0.35 m wide, overlaps the block.
bool is_in_block(Simulation& simulation) {
  const Vec3<double> p = simulation.bodies()[0].position;
  return std::abs(p.x) < 1.9 && std::abs(p.y) < 1.9;
}

TEST(StartOverlap, IsDrawnAgainUntilNothingOverlaps) {
  Simulation taken = hover(with(kBlock, kStart, {"contact.redraws=0"}));
  Simulation redrawn = hover(with(kBlock, kStart, {"contact.redraws=100"}));
  int inside = 0;
  for (int k = 0; k < 100; ++k) {
    taken.reset();
    redrawn.reset();
    EXPECT_FALSE(taken.fault());
    EXPECT_FALSE(redrawn.fault());
    EXPECT_FALSE(is_in_block(redrawn)) << k;
    inside += is_in_block(taken) ? 1 : 0;
    // Starts that needed no second draw keep their bits.
    if (taken.contacts().empty()) {
      EXPECT_EQ(taken.state("q"), redrawn.state("q")) << k;
    }
  }
  EXPECT_GT(inside, 30);
  EXPECT_LT(inside, 90);
}

TEST(StartOverlap, IsAFaultWithItsReasonWhereDrawingDoesNotHelp) {
  const std::string wall = "obstacles=[{name: hall, box: [20, 20, 2], position: [0, 0, 1]}]";
  Simulation simulation = hover(with(wall, kStart, {"contact.redraws=3"}));
  simulation.reset();
  EXPECT_TRUE(simulation.fault());
  EXPECT_TRUE(simulation.truncated());
  EXPECT_EQ(simulation.reward(), 0.0f);
  EXPECT_THAT(reason(simulation), HasSubstr("robot `quad` begins inside the obstacle `hall`, by "));
  EXPECT_THAT(reason(simulation), HasSubstr("raise `contact.redraws` (3)"));
  // Values read as doubles keep the bits of a status.
  EXPECT_EQ(simulation.state("status")[0], static_cast<double>(simulation.status()));
  EXPECT_LT(simulation.status(), std::uint64_t{1} << 53);
}

TEST(StartOverlap, OfTheScenarioItselfIsNoFault) {
  const std::string wall = "obstacles=[{name: hall, box: [20, 20, 2], position: [0, 0, 5]}]";
  const std::string masses = "{plugin: vehicle_constants, parameters: {mass: [0.9, 1.1]}}";
  Simulation simulation = hover(with(wall, masses));
  simulation.reset();
  EXPECT_FALSE(simulation.fault());
  const std::string lifted =
      "{plugin: start, parameters: {relative: true, position_min: [0, 0, 0.1], position_max: [0, "
      "0, 0.2]}}";
  Simulation less = hover(with(wall, lifted));
  less.reset();
  EXPECT_FALSE(less.fault()) << "it is not as deep as in the scenario";
}

TEST(StartOverlap, OfWhatStandsOnTheGroundIsNone) {
  const std::string standing =
      "{plugin: start, parameters: {position_min: [-1, -1, 0.055], position_max: [1, 1, 0.06]}}";
  Simulation simulation = hover(with("obstacles=[]", standing));
  for (int k = 0; k < 20; ++k) {
    simulation.reset();
    EXPECT_FALSE(simulation.fault()) << reason(simulation);
  }
  const std::string sunk =
      "{plugin: start, parameters: {position_min: [-1, -1, 0.02], position_max: [1, 1, 0.03]}}";
  Simulation deep = hover(with("obstacles=[]", sunk));
  deep.reset();
  EXPECT_TRUE(deep.fault());
  EXPECT_THAT(reason(deep), HasSubstr("robot `quad` begins inside the ground, by 0.0"));
}

TEST(StartOverlap, CountsForObstaclesThatAreDrawnAndThatAreNotThere) {
  const std::string pole = "obstacles=[{name: pole, sphere: 0.5, position: [0, 0, 20]}]";
  const std::string moved =
      "{plugin: draw, name: place, parameters: {what: ['obstacles.pole.position[2]'], range: "
      "[4, 7]}}";
  Simulation simulation = hover(with(pole, moved));
  for (int k = 0; k < 100; ++k) {
    simulation.reset();
    ASSERT_FALSE(simulation.fault());
    const double height = simulation.param("obstacles.pole.position[2]");
    EXPECT_TRUE(height < 4.49 || height > 5.52) << height;
  }
  const std::string absent =
      "{plugin: draw, name: there, parameters: {what: [obstacles.pole.present], range: [0, "
      "0]}}";
  const std::string at_robot = "obstacles=[{name: pole, sphere: 0.5, position: [0, 0, 1]}]";
  Simulation without = hover(
      with(at_robot,
           "{plugin: start, parameters: {position_min: [0, 0, 1], position_max: [0, 0, 1]}}, " +
               absent));
  without.reset();
  EXPECT_FALSE(without.fault());
}

/// A randomizer that is not due keeps its values; the schedule counts a reset once.
TEST(StartOverlap, DrawsWhatIsDueAndCountsTheResetOnce) {
  const std::string mass = "{plugin: vehicle_constants, parameters: {mass: [0.5, 1.5], every: 3}}";
  Simulation taken = hover(with(kBlock, kStart + ", " + mass, {"contact.redraws=0"}));
  Simulation redrawn = hover(with(kBlock, kStart + ", " + mass, {"contact.redraws=100"}));
  double last = 0.0;
  for (int k = 0; k < 30; ++k) {
    taken.reset();
    redrawn.reset();
    const double now = redrawn.param("robots.quad.links.base_link.mass");
    EXPECT_EQ(now != last, k % 3 == 0) << k;
    if (k % 3 == 0 && !is_in_block(taken)) {
      EXPECT_EQ(now, taken.param("robots.quad.links.base_link.mass"));
    }
    last = now;
  }
}

TEST(StartOverlap, OfTwoRobotsIsDrawnAgain) {
  const std::string scenario = "formation";
  Simulation simulation(
      {.scenario = scenario,
       .overrides = {"randomization=[{plugin: start, parameters: {position_min: [-0.7, -0.7, 1], "
                     "position_max: [0.7, 0.7, 2]}}]",
                     "contact.redraws=1000"}});
  int touching = 0;
  for (int k = 0; k < 20; ++k) {
    simulation.reset();
    EXPECT_FALSE(simulation.fault()) << reason(simulation);
    for (const Contact& c : simulation.contacts()) touching += c.depth > 0.01 ? 1 : 0;
  }
  EXPECT_EQ(touching, 0);
}

/// A lane's draws are a function of its own key: alone, in packs, on any number of threads.
TEST(StartOverlap, HasTheSameBitsInPacksAndOnThreads) {
  const auto compiled =
      compile_scenario({"hover", with(kBlock, kStart, {"contact.redraws=5"}), {}});
  constexpr int kEnvs = 70;
  std::vector<std::uint64_t> hashes;
  std::vector<std::uint64_t> first;
  int faults = 0;
  for (const int threads : {1, 2}) {
    Pool pool(compiled, {.envs = kEnvs, .threads = threads, .seed = 4, .keep_hash = true});
    pool.send_reset();
    const auto batch = pool.recv();
    if (threads == 1) {
      first.assign(batch->status.begin(), batch->status.begin() + kEnvs);
      for (int i = 0; i < kEnvs; ++i) faults += batch->fault[static_cast<std::size_t>(i)];
    }
    hashes.push_back(pool.hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_GT(faults, 0);
  EXPECT_LT(faults, kEnvs / 2);
  Pool pool(compiled, {.envs = kEnvs, .threads = 1, .seed = 4});
  pool.send_reset();
  pool.recv();
  std::vector<double> q(kEnvs * 7);
  pool.state("q", q);
  for (int env = 0; env < kEnvs; ++env) {
    Simulation alone(compiled, 4, static_cast<std::uint64_t>(env));
    alone.reset();
    const std::vector<double> own = alone.state("q");
    EXPECT_EQ(own, std::vector<double>(q.begin() + 7 * env, q.begin() + 7 * env + 7)) << env;
    EXPECT_EQ(alone.status(), first[static_cast<std::size_t>(env)]) << env;
  }
}

}  // namespace
}  // namespace skybody
