// Tree and Simbody take turns: who steps follows from the state alone, and the flight is Simbody's.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "tests/unit/physics/random_trees.h"
#include "tests/unit/physics/tree_dynamics.h"

namespace skybody::test {
namespace {

/// Two vehicles in the air, `apart` [m] along x.
Scenario pair_of_vehicles(double apart, DynamicsChoice dynamics = DynamicsChoice::kAuto,
                          IntegratorChoice integrator = IntegratorChoice::kSemiImplicitEuler) {
  Scenario scenario = make_scenario(make_vehicle(qdrone2()), integrator);
  scenario.stepping.dynamics = dynamics;
  scenario.robots.push_back(scenario.robots[0]);
  scenario.robots[1].name = "s";
  scenario.robots[0].pose = {{-0.5 * apart, 0.02, 3.0}, from_rpy(0.05, 0.1, 0.3)};
  scenario.robots[1].pose = {{0.5 * apart, -0.03, 3.01}, from_rpy(-0.1, 0.05, -0.4)};
  return scenario;
}

/// Flies the pair towards each other; rotors carry most of their weight.
void set_off(Bench& bench, double speed) {
  bench.state.u[0] = speed;
  bench.state.u[6] = -speed;
  for (int axis = 0; axis < 3; ++axis) {
    bench.state.u[static_cast<std::size_t>(3 + axis)] = 0.3 - 0.4 * axis;
    bench.state.u[static_cast<std::size_t>(9 + axis)] = 0.2 * axis;
  }
  bench.state.rotor_speed.assign(8, 1380.0);
  bench.state.rotor_command = {1400.0, 1390.0, 1400.0, 1395.0, 1395.0, 1400.0, 1390.0, 1400.0};
}

bool same_bits(const LaneState& a, const LaneState& b) {
  const auto same = [](const std::vector<double>& x, const std::vector<double>& y) {
    return x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(double)) == 0;
  };
  return same(a.q, b.q) && same(a.u, b.u) && same(a.rotor_speed, b.rotor_speed) &&
         std::memcmp(a.bodies.data(), b.bodies.data(), a.bodies.size() * sizeof(BodyState)) == 0;
}

/// Greatest difference of any coordinate or rate [m, m/s, 1, rad/s].
double difference(const LaneState& a, const LaneState& b) {
  return std::max(largest_difference(a.q, b.q), largest_difference(a.u, b.u));
}

TEST(HandOver, FliesOnTreeFarFromEverything) {
  for (const IntegratorChoice integrator : kFixedSteps) {
    Bench chosen(pair_of_vehicles(3.0, DynamicsChoice::kAuto, integrator));
    Bench tree(pair_of_vehicles(3.0, DynamicsChoice::kAuto, integrator));
    tree.stepper = make_tree_stepper(tree.world);
    Bench simbody(pair_of_vehicles(3.0, DynamicsChoice::kSimbody, integrator));
    for (Bench* bench : {&chosen, &tree, &simbody}) set_off(*bench, 0.2);
    for (int i = 0; i < 1000; ++i) {
      for (Bench* bench : {&chosen, &tree, &simbody}) ASSERT_TRUE(bench->run(1));
      ASSERT_FALSE(chosen.stepper->was_on_simbody()) << i;
      ASSERT_TRUE(simbody.stepper->was_on_simbody()) << i;
    }
    EXPECT_TRUE(same_bits(chosen.state, tree.state));
    EXPECT_FALSE(same_bits(chosen.state, simbody.state)) << "rounding tells them apart";
    // As FreeBody.TumblesLikeSimbodysForASecond: 1000 steps of roundings around 1e-15.
    EXPECT_LT(difference(chosen.state, simbody.state), 1e-11);
  }
}

/// Who flew, step by step.
struct Turns {
  int tree = 0, simbody = 0, changes = 0;
  void add(bool on_simbody) {
    changes += tree + simbody > 0 && on_simbody != last;
    (on_simbody ? simbody : tree) += 1;
    last = on_simbody;
  }
  bool last = false;
};

/// Every step is, to the last bit, one of Simbody or one of tree from the same state; and while it
/// is one of tree, Simbody sees no contact and steps the same within rounding.
TEST(HandOver, TakesEachStepAsOneOfTheTwoDoes) {
  for (const IntegratorChoice integrator : kFixedSteps) {
    Bench chosen(pair_of_vehicles(2.0, DynamicsChoice::kAuto, integrator));
    const auto tree = make_tree_stepper(chosen.world);
    const auto simbody = make_simbody_stepper(chosen.world);
    set_off(chosen, 1.5);
    Turns turns;
    for (int i = 0; i < 2500; ++i) {
      LaneState by_tree = chosen.state, by_simbody = chosen.state;
      std::vector<Contact> contacts;
      simbody->add_contacts(by_simbody, contacts);
      ASSERT_TRUE(chosen.run(1));
      ASSERT_TRUE(tree->advance(by_tree));
      ASSERT_TRUE(simbody->advance(by_simbody));
      const bool on_simbody = chosen.stepper->was_on_simbody();
      turns.add(on_simbody);
      ASSERT_TRUE(same_bits(chosen.state, on_simbody ? by_simbody : by_tree)) << i;
      if (on_simbody) continue;
      ASSERT_TRUE(contacts.empty()) << i;
      // The ground changes rates by at most 10 rad/s in a step, computed by either in some hundred
      // operations of 1e-16 each.
      ASSERT_LT(difference(by_tree, by_simbody), 1e-13) << i;
    }
    EXPECT_GT(turns.tree, 500);
    EXPECT_GT(turns.simbody, 50);
    EXPECT_GE(turns.changes, 2) << "over to Simbody and back";
  }
}

/// The first collision, from 0.4 s before the touch to 0.1 s after the first one.
TEST(HandOver, CollidesAsOnSimbodyThroughout) {
  Bench chosen(pair_of_vehicles(2.0));
  Bench simbody(pair_of_vehicles(2.0, DynamicsChoice::kSimbody));
  for (Bench* bench : {&chosen, &simbody}) set_off(*bench, 1.5);
  double before = 0.0, after = 0.0, push = 0.0;
  int touched = 0;
  for (int i = 0; i < 2000 && touched < 100; ++i) {
    std::vector<Contact> contacts;
    simbody.stepper->add_contacts(simbody.state, contacts);
    touched += touched > 0 || !contacts.empty();
    for (const Contact& contact : contacts) push = std::max(push, norm(contact.force));
    for (Bench* bench : {&chosen, &simbody}) ASSERT_TRUE(bench->run(1));
    double& most = touched == 0 ? before : after;
    most = std::max(most, difference(chosen.state, simbody.state));
  }
  EXPECT_EQ(touched, 100);
  EXPECT_GT(push, 10.0) << "newtons: a collision";
  // Some 500 steps, in each of which a height of 3 m is rounded to 4e-16 m.
  EXPECT_LT(before, 1e-12);
  // The vehicles' contact is a spring of some 100 rad/s: it turns differences of place into a
  // hundred times larger ones of velocity.
  EXPECT_LT(after, 1e-10);
}

TEST(HandOver, ComesBackAfterAnObstacle) {
  Scenario scenario = make_scenario(make_free_body(1.0, diagonal(0.01, 0.01, 0.01)));
  scenario.robots[0].model.bodies[0].collisions = {make_sphere(0.1)};
  scenario.constants[kGravity + 2] = 0.0;
  Obstacle wall{"wall", make_box(0.2, 1.0, 1.0)};
  wall.shape.pose.position = {0.5, 0.0, 3.0};
  scenario.obstacles.push_back(wall);
  scenario.robots[0].pose.position.z = 3.0;
  Bench bench(std::move(scenario));
  bench.state.u[0] = 1.0;
  Turns turns;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(bench.run(1));
    turns.add(bench.stepper->was_on_simbody());
    // The sphere's centre 0.1 m from the wall, and what one step adds.
    const double x = bench.state.q[0];
    EXPECT_TRUE(x > 0.29 || !turns.last) << i;
    EXPECT_TRUE(x < 0.305 || turns.last) << i;
  }
  EXPECT_EQ(turns.changes, 2);
  EXPECT_LT(bench.state.u[0], -0.2) << "thrown back";
}

TEST(HandOver, DoesNotDependOnWhatTheStepperSawBefore) {
  Bench a(pair_of_vehicles(2.0)), b(pair_of_vehicles(2.0));
  set_off(a, 1.5);
  while (!a.stepper->was_on_simbody()) ASSERT_TRUE(a.run(1));
  ASSERT_TRUE(a.run(100));
  for (const int further : {0, 600}) {  // in the midst of the collision, and later
    ASSERT_TRUE(a.run(further));
    const LaneState saved = a.state;
    ASSERT_TRUE(a.run(300));
    // b serves another environment in between, with other masses, then one that fails on Simbody.
    b.param("robots.s.links.base.mass") = 3.0;
    b.state.q[0] = b.state.q[7] - 0.1;
    ASSERT_TRUE(b.run(37));
    b.state.u[0] = kInfinity;
    EXPECT_FALSE(b.run(1));
    b.state = saved;
    ASSERT_TRUE(b.run(300));
    EXPECT_TRUE(same_bits(a.state, b.state));
    a.state = saved;
    ASSERT_TRUE(a.run(300));
    EXPECT_TRUE(same_bits(a.state, b.state));
  }
}

/// A question is answered by whoever would take the step.
TEST(HandOver, AnswersQuestionsAsItSteps) {
  for (const double apart : {0.2, 3.0}) {
    Bench chosen(pair_of_vehicles(apart));
    const auto tree = make_tree_stepper(chosen.world);
    const auto simbody = make_simbody_stepper(chosen.world);
    std::vector<double> asked(12), by_tree(12), by_simbody(12);
    chosen.stepper->accelerations(chosen.state, asked.data());
    tree->accelerations(chosen.state, by_tree.data());
    simbody->accelerations(chosen.state, by_simbody.data());
    EXPECT_EQ(asked, apart < 1.0 ? by_simbody : by_tree);
    std::vector<Contact> contacts;
    chosen.stepper->add_contacts(chosen.state, contacts);
    EXPECT_EQ(contacts.empty(), apart > 1.0);
  }
}

/// The bounding volumes miss nothing: where Reach sees nothing, Simbody finds no contact.
TEST(HandOver, NeverMissesAContactOfSimbodys) {
  int apart = 0, near = 0, touching = 0;
  for (std::uint64_t k = 0; k < 25; ++k) {
    Random<double> random{RandomKey{2026, 32}, k, 0, derive_stream("hand_over_test")};
    const auto size = [&] { return random.uniform(0.02, 0.4); };
    const auto shape = [&] {
      const double kind = random.uniform();
      Shape out = kind < 0.3   ? make_sphere(size())
                  : kind < 0.6 ? make_cylinder(size(), size())
                               : make_box(size(), size(), size());
      out.pose = {in_cube(random, 0.3), random.quaternion()};
      return out;
    };
    RobotModel model = make_free_body(1.0, diagonal(0.01, 0.01, 0.01));
    model.bodies[0].collisions = {shape(), shape()};
    Scenario scenario = make_scenario(model);
    scenario.robots.push_back(scenario.robots[0]);
    scenario.robots[1].name = "s";
    if (k % 2 == 0) scenario.obstacles.push_back({"obstacle", shape()});
    Bench bench(std::move(scenario));
    const auto simbody = make_nominal_simbody(bench.world);
    for (int i = 0; i < 40; ++i) {
      random_state(random, bench.world, bench.state.q, bench.state.u);
      store(in_cube(random, 0.8), bench.state.q.data());
      store(in_cube(random, 0.8), bench.state.q.data() + 7);
      LaneState next = bench.state;
      bench.stepper->advance(next);
      std::vector<Contact> contacts;
      simbody->add_contacts(bench.state.q.data(), bench.state.u.data(), contacts);
      const bool on_simbody = bench.stepper->was_on_simbody();
      (on_simbody ? near : apart) += 1;
      touching += !contacts.empty();
      ASSERT_TRUE(on_simbody || contacts.empty()) << k << ' ' << i;
    }
  }
  EXPECT_GT(apart, 100);
  EXPECT_GT(touching, 100);
  EXPECT_GT(near, touching);
}

}  // namespace
}  // namespace skybody::test
