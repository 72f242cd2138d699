// Contact lists at their limits:
// - bodies with more contacts than the list between the passes of a part keeps
// - so many obstacles that each lane's distance to them is cached, with lanes gathered from the
//   whole
//   group
#include <gtest/gtest.h>

#include "tests/unit/physics/contact_worlds.h"

namespace skybody::test {
namespace {

/// A floor of 10 x 10 boxes on one body.
RobotModel tiles() {
  RobotModel model = solid(2.0, make_box(1.0, 1.0, 0.05));
  model.bodies[0].collisions.clear();
  for (int k = 0; k < 100; ++k) {
    Shape tile = make_box(0.08, 0.08, 0.05);
    tile.pose.position = {0.1 * (k % 10) - 0.45, 0.1 * (k / 10) - 0.45, 0.0};
    model.bodies[0].collisions.push_back(tile);
  }
  return model;
}

double carried(Bench& bench) {
  std::vector<Contact> contacts;
  bench.stepper->add_contacts(bench.state, contacts);
  EXPECT_EQ(contacts.size(), 400u);
  double sum = 0.0;
  for (const Contact& c : contacts) sum += c.force.z;
  return sum;
}

TEST(ManyShapes, LieOnTheGroundWithAllOfTheirCorners) {
  Scenario scenario = world_of(tiles());
  scenario.robots[0].pose.position = {0, 0, 0.03};
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(1.0));
  EXPECT_NEAR(carried(bench), 2.0 * 9.81, 1e-3);
  EXPECT_LT(norm(load_vec3(bench.state.u.data())), 1e-6);
}

TEST(ManyShapes, LieOnAnObstacleWithAllOfTheirCorners) {
  Scenario scenario = world_of(tiles());
  scenario.contact.ground = false;
  add_box(scenario, "table", {2.0, 2.0, 0.5}, {{0, 0, -0.25}, {1, 0, 0, 0}});
  scenario.robots[0].pose.position = {0, 0, 0.03};
  Bench bench(scenario);
  ASSERT_TRUE(bench.run_seconds(1.0));
  EXPECT_NEAR(carried(bench), 2.0 * 9.81, 1e-3);
}

/// A box far from its body's origin, among twelve posts.
Scenario among_posts() {
  Shape box = make_box(0.1, 0.08, 0.06);
  box.pose.position = {0.15, 0.02, -0.01};
  Scenario scenario = world_of(solid(0.5, box));
  for (int k = 0; k < 12; ++k) {
    const Pose pose{{0.5 * (k % 4) - 0.75, 0.5 * (k / 4) - 0.5, 0.5}, {1, 0, 0, 0}};
    add_box(scenario, "post_" + std::to_string(k), {0.06, 0.06, 1.0}, pose);
  }
  return scenario;
}

TEST(ManyObstacles, AreToALaneWhatTheyAreToItAlone) {
  constexpr int kSteps = 800;
  const World world = make_world(among_posts());
  const GroupPhysics physics(world);
  PackGroup packs(world, physics);
  Alone alone(world);
  LaneState state;
  write_default_state(world, state);
  Random<double> random{RandomKey{2026, 62}, 0, 0, derive_stream("contact_lists_test")};
  for (int lane = 0; lane < kGroupLanes; ++lane) {
    store(in_cube(random, 0.7) + Vec3<double>{0, 0, 0.9}, state.q.data());
    store(random.quaternion(), state.q.data() + 3);
    store(in_cube(random, 3.0), state.u.data());
    store(in_cube(random, 8.0), state.u.data() + 3);
    packs.set(lane, state);
    alone.set(lane, state);
  }
  packs.refresh(kAllLanes);
  alone.refresh(kAllLanes);
  int near_some = 0;
  for (int step = 0; step < kSteps; ++step) {
    const std::uint32_t lanes = step % 2 == 0 ? kAllLanes : kSomeLanes;
    ASSERT_EQ(packs.advance(lanes), lanes) << step;
    ASSERT_EQ(alone.advance(lanes), lanes) << step;
    ASSERT_EQ(packs.stepper->near(), alone.near) << step;
    if (alone.near != 0 && alone.near != lanes) ++near_some;
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      const std::vector<double>& q = alone.states[static_cast<std::size_t>(lane)].q;
      for (std::size_t k = 0; k < q.size(); ++k) {
        const double found =
            packs.values_at(&StateLayout::q)[k * kGroupLanes + static_cast<std::size_t>(lane)];
        ASSERT_EQ(found, q[k]) << "step " << step << ", lane " << lane << ", value " << k;
      }
    }
  }
  EXPECT_GT(near_some, kSteps / 2) << "steps in which some lanes are near something, others not";
}

}  // namespace
}  // namespace skybody::test
