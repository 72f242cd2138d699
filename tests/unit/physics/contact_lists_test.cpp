// Bodies of so many shapes that the places where they touch do not fit into the list that is kept
// between the passes of a part.
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

}  // namespace
}  // namespace skybody::test
