// Inputs held by effects during a physics step: each against its closed form, on all dynamics.
#include "core/physics/step/held_input_set.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <initializer_list>

#include "core/physics/forces/rotor_force.h"
#include "core/physics/step/free_robots.h"
#include "tests/unit/physics/random_trees.h"

namespace skybody::test {
namespace {

using Held = std::array<bool, SKYBODY_HELD_COUNT>;
constexpr Held kAll{true, true, true, true, true, true, true};

Held only(std::initializer_list<int> inputs) {
  Held held{};
  for (const int input : inputs) held[static_cast<std::size_t>(input)] = true;
  return held;
}

RobotModel make_dragging_vehicle() {
  RobotModel model = make_vehicle(qdrone2());
  for (Rotor& rotor : model.rotors) {
    rotor.constants[kDragConstant] = 2e-4;
    rotor.constants[kRollingMomentConstant] = 1e-5;
    rotor.constants[kRotorInertia] = 5e-6;
  }
  return model;
}

/// A robot high above the ground.
Scenario aloft(RobotModel model, IntegratorChoice integrator = IntegratorChoice::kRk4) {
  Scenario scenario = make_scenario(std::move(model), integrator);
  scenario.robots[0].pose.position.z = 100.0;
  return scenario;
}

Bench make_bench(Scenario scenario, Held held = kAll) {
  return Bench(std::move(scenario), [held](WorldPlan& plan) { plan.holds = held; });
}

void set_speeds(Bench& bench, double speed) {
  bench.state.rotor_speed.assign(bench.state.rotor_speed.size(), speed);
  bench.state.rotor_command = bench.state.rotor_speed;
}

std::vector<double> accelerations(Bench& bench) {
  std::vector<double> udot(bench.state.u.size());
  bench.stepper->accelerations(bench.state, udot.data());
  return udot;
}

TEST(HeldInputs, TakeNoWordsWhereNothingHoldsThem) {
  const World world(aloft(make_dragging_vehicle()));
  for (const Block& held : world.layout.held) EXPECT_EQ(held.size, 0);
}

TEST(HeldInputs, LieBehindTheBristlesWithTheirNeutralValues) {
  const Bench bench = make_bench(aloft(make_dragging_vehicle()));
  const StateLayout& layout = bench.world.layout;
  EXPECT_EQ(layout.held[SKYBODY_HELD_WIND].offset, layout.bristles.offset + layout.bristles.size);
  EXPECT_EQ(layout.held[SKYBODY_HELD_WRENCH].size, 6);
  EXPECT_EQ(layout.held[SKYBODY_HELD_ROTOR_GAIN].size, 16);
  EXPECT_EQ(bench.state.held[SKYBODY_HELD_WIND], std::vector<double>(3, 0.0));
  EXPECT_EQ(bench.state.held[SKYBODY_HELD_WRENCH], std::vector<double>(6, 0.0));
  EXPECT_EQ(bench.state.held[SKYBODY_HELD_ROTOR_GAIN], std::vector<double>(16, 1.0));
  EXPECT_EQ(bench.state.held[SKYBODY_HELD_ROTOR_LIMIT][6], 0.0);
  EXPECT_EQ(bench.state.held[SKYBODY_HELD_ROTOR_LIMIT][7], kInfinity);
  for (const double rate : bench.state.held[SKYBODY_HELD_ROTOR_RATE]) EXPECT_TRUE(std::isnan(rate));
}

TEST(HeldInputs, DragInAWindIsThatOfTheOppositeVelocityInStillAir) {
  const Vec3<double> wind{3.0, -2.0, 0.5};
  Bench in_wind = make_bench(aloft(make_dragging_vehicle()), only({SKYBODY_HELD_WIND}));
  Bench moving(aloft(make_dragging_vehicle()));
  for (Bench* bench : {&in_wind, &moving}) {
    set_speeds(*bench, 900.0);
    store(from_rpy(0.3, -0.2, 1.0), bench->state.q.data() + 3);
    store(Vec3<double>{0.5, -1.0, 2.0}, bench->state.u.data() + 3);
  }
  store(wind, in_wind.state.held[SKYBODY_HELD_WIND].data());
  store(-wind, moving.state.u.data());
  const std::vector<double> a = accelerations(in_wind), b = accelerations(moving);
  EXPECT_LT(largest_difference(a, b), 1e-13 * largest(b)) << "a few roundings";
}

TEST(HeldInputs, WindThatMovesWithTheBodyDragsNothing) {
  Bench carried = make_bench(aloft(make_dragging_vehicle()), only({SKYBODY_HELD_WIND}));
  Bench at_rest(aloft(make_dragging_vehicle()));
  for (Bench* bench : {&carried, &at_rest}) set_speeds(*bench, 900.0);
  const Vec3<double> velocity{4.0, 1.0, -3.0};
  store(velocity, carried.state.u.data());
  store(velocity, carried.state.held[SKYBODY_HELD_WIND].data());
  EXPECT_EQ(accelerations(carried), accelerations(at_rest));
  const double start = carried.state.u[0];
  ASSERT_TRUE(carried.run(100));
  EXPECT_NEAR(carried.state.u[0], start, 1e-13) << "and takes no energy";
}

TEST(HeldInputs, AWrenchActsAtTheCentreOfMassInWorldAxes) {
  const MassProperties mass{2.0, {0.1, -0.05, 0.02}, diagonal(0.02, 0.03, 0.04)};
  RobotModel model = make_free_body(mass.mass, mass.inertia, mass.com);
  Scenario scenario = aloft(model);
  scenario.constants[kGravity + 2] = 0.0;
  Bench bench = make_bench(std::move(scenario), only({SKYBODY_HELD_WRENCH}));
  const Quat<double> turn = from_rpy(0.4, 0.2, -0.7);
  store(turn, bench.state.q.data() + 3);
  const Vec3<double> force{1.0, 2.0, -3.0}, moment{0.1, -0.2, 0.3};
  store(force, bench.state.held[SKYBODY_HELD_WRENCH].data());
  store(moment, bench.state.held[SKYBODY_HELD_WRENCH].data() + 3);
  const std::vector<double> udot = accelerations(bench);
  const Vec3<double> angular = inverse(mass.inertia) * rotate_inverse(turn, moment);
  const Vec3<double> of_com =
      load_vec3(udot.data()) + rotate(turn, cross(load_vec3(udot.data() + 3), mass.com));
  EXPECT_LT(norm(load_vec3(udot.data() + 3) - angular), 1e-13);
  EXPECT_LT(norm(of_com - force * (1.0 / mass.mass)), 1e-13);
}

TEST(HeldInputs, BodyDragActsAlongEachBodyAxisAgainstTheAir) {
  const MassProperties mass{2.0, {0.1, -0.05, 0.02}, diagonal(0.02, 0.03, 0.04)};
  Scenario scenario = aloft(make_free_body(mass.mass, mass.inertia, mass.com));
  scenario.constants[kGravity + 2] = 0.0;
  Bench bench = make_bench(std::move(scenario), only({SKYBODY_HELD_WIND, SKYBODY_HELD_BODY_DRAG}));
  const Quat<double> turn = from_rpy(0.4, 0.2, -0.7);
  const Vec3<double> velocity{3.0, 1.0, -2.0}, spin{0.5, -1.0, 0.3}, wind{-1.0, 2.0, 0.5};
  store(turn, bench.state.q.data() + 3);
  store(velocity, bench.state.u.data());
  store(spin, bench.state.u.data() + 3);
  store(wind, bench.state.held[SKYBODY_HELD_WIND].data());
  bench.state.held[SKYBODY_HELD_BODY_DRAG] = {0.1, 0.2, 0.3, 0.04, 0.05, 0.06};
  const std::vector<double> udot = accelerations(bench);
  const Vec3<double> v = rotate_inverse(turn, velocity - wind) + cross(spin, mass.com);
  const auto drag = [speed = norm(v)](double x, double linear, double quadratic) {
    return -(linear * x + quadratic * speed * x);
  };
  const Vec3<double> force{drag(v.x, 0.1, 0.04), drag(v.y, 0.2, 0.05), drag(v.z, 0.3, 0.06)};
  const Vec3<double> angular = load_vec3(udot.data() + 3);
  const Vec3<double> of_com = load_vec3(udot.data()) + rotate(turn, cross(angular, mass.com)) +
                              rotate(turn, cross(spin, cross(spin, mass.com)));
  EXPECT_LT(norm(of_com - rotate(turn, force) * (1.0 / mass.mass)), 1e-13);
  EXPECT_LT(norm(mass.inertia * angular + cross(spin, mass.inertia * spin)), 1e-13)
      << "no moment about the centre of mass";
}

/// The accelerations with these gains of `place`.
std::vector<double> with_gains(int place, const std::vector<double>& gains) {
  RobotModel model = make_dragging_vehicle();
  for (Rotor& rotor : model.rotors) rotor.constants[kRotorInertia] = 0.0;
  Scenario scenario = aloft(model);
  scenario.constants[kGravity + 2] = 0.0;
  Bench bench = make_bench(std::move(scenario), only({SKYBODY_HELD_ROTOR_GAIN}));
  set_speeds(bench, 800.0);
  bench.state.u[0] = 5.0;
  for (std::size_t i = 0; i < gains.size(); ++i) {
    bench.state
        .held[SKYBODY_HELD_ROTOR_GAIN][kGainedConstants * i + static_cast<std::size_t>(place)] =
        gains[i];
  }
  return accelerations(bench);
}

TEST(HeldInputs, AGainOnThrustScalesTheThrust) {
  const VehicleData d = qdrone2();
  const std::vector<double> udot = with_gains(0, {0.5, 1.5, 0.5, 1.0});
  EXPECT_NEAR(udot[2], 3.5 * d.kf * 800.0 * 800.0 / d.mass, 1e-12);
}

TEST(HeldInputs, AGainOnTheReactionScalesTheReaction) {
  const VehicleData d = qdrone2();
  const std::vector<double> udot = with_gains(1, {2.0, 1.0, 0.0, 1.0});
  // Directions + - + -, so that the reactions are -2 + 1 - 0 + 1 = 0 of k_m w^2; without the gains
  // of rotors 0 and 2 they would be 0 as well.
  const std::vector<double> twice = with_gains(1, {2.0, 1.0, 1.0, 1.0});
  const double reaction = d.km * 800.0 * 800.0 / d.inertia.zz;
  EXPECT_NEAR(udot[5], 0.0, 1e-12);
  EXPECT_NEAR(twice[5], -reaction, 1e-12);
}

TEST(HeldInputs, AGainOnRotorDragScalesTheDrag) {
  const std::vector<double> udot = with_gains(2, {0.0, 0.0, 3.0, 0.0});
  EXPECT_NEAR(udot[0], -3.0 * 2e-4 * 800.0 * 5.0 / qdrone2().mass, 1e-12);
}

TEST(HeldInputs, AGainOnTheRollingMomentScalesIt) {
  const std::vector<double> udot = with_gains(3, {0.0, 2.0, 0.0, 0.0});
  // M = -s c_r w v', s = -1.
  EXPECT_NEAR(udot[3], 2.0 * 1e-5 * 800.0 * 5.0 / qdrone2().inertia.xx, 1e-12);
}

TEST(HeldInputs, TheFlowAtAHubDragsLiftsAndFlaps) {
  const VehicleData d = qdrone2();
  Scenario scenario = aloft(make_vehicle(d));
  scenario.constants[kGravity + 2] = 0.0;
  Bench with = make_bench(scenario, only({SKYBODY_HELD_WIND, SKYBODY_HELD_ROTOR_FLOW}));
  Bench without(scenario);
  const Quat<double> turn = from_rpy(0.4, 0.2, -0.7);
  const Vec3<double> velocity{3.0, 1.0, -2.0}, spin{0.5, -1.0, 0.3}, wind{-1.0, 2.0, 0.5};
  for (Bench* bench : {&with, &without}) {
    set_speeds(*bench, 800.0);
    store(turn, bench->state.q.data() + 3);
    store(velocity - (bench == &without ? wind : Vec3<double>{0, 0, 0}), bench->state.u.data());
    store(spin, bench->state.u.data() + 3);
  }
  store(wind, with.state.held[SKYBODY_HELD_WIND].data());
  const double axial = 1e-4, flapping = 3e-5, lift = 2e-3, w = 800.0;
  for (std::size_t i = 0; i < 2; ++i) {  // of the first two rotors
    with.state.held[SKYBODY_HELD_ROTOR_FLOW][3 * i] = axial;
    with.state.held[SKYBODY_HELD_ROTOR_FLOW][3 * i + 1] = flapping;
    with.state.held[SKYBODY_HELD_ROTOR_FLOW][3 * i + 2] = lift;
  }
  Vec3<double> force{0, 0, 0}, moment{0, 0, 0};
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3<double> hub_place = with.world.rotors[i].model->position();
    const Vec3<double> hub = rotate_inverse(turn, velocity - wind) + cross(spin, hub_place);
    const Vec3<double> up{0, 0, lift * (hub.x * hub.x + hub.y * hub.y) - axial * w * hub.z};
    force += up;
    moment += cross(hub_place, up) - cross(hub, Vec3<double>{0, 0, 1}) * (flapping * w);
  }
  const std::vector<double> a = accelerations(with), b = accelerations(without);
  const Vec3<double> linear = load_vec3(a.data()) - load_vec3(b.data());
  const Vec3<double> angular = load_vec3(a.data() + 3) - load_vec3(b.data() + 3);
  EXPECT_LT(norm(linear - rotate(turn, force) * (1.0 / d.mass)), 1e-13);
  EXPECT_LT(norm(angular - inverse(d.inertia) * moment), 1e-11);
}

TEST(HeldInputs, LimitsBoundTheSpeedThatARotorRunsTo) {
  Bench bench = make_bench(aloft(make_dragging_vehicle()), only({SKYBODY_HELD_ROTOR_LIMIT}));
  bench.state.rotor_speed = {600, 600, 600, 600};
  bench.state.rotor_command = {2000, 0, 2000, 900};
  bench.state.held[SKYBODY_HELD_ROTOR_LIMIT] = {0, 1000, 300, kInfinity, 0, 1e5, 0, kInfinity};
  bench.param("robots.r.rotors[2].max_speed") = 1500.0;
  ASSERT_TRUE(bench.run_seconds(1.5));
  const double expected[] = {1000, 300, 1500, 900};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(bench.state.rotor_speed[i], expected[i], 1e-9);
}

TEST(HeldInputs, ARateMakesTheSpeedLinearUpToTheLimits) {
  Bench bench = make_bench(aloft(make_dragging_vehicle()),
                           only({SKYBODY_HELD_ROTOR_LIMIT, SKYBODY_HELD_ROTOR_RATE}));
  set_speeds(bench, 600.0);
  bench.state.held[SKYBODY_HELD_ROTOR_RATE] = {1000.0, -2000.0, kNan, 1e5};
  bench.state.held[SKYBODY_HELD_ROTOR_LIMIT] = {0, kInfinity, 550, kInfinity,
                                                0, kInfinity, 0,   kInfinity};
  ASSERT_TRUE(bench.run(100));
  EXPECT_NEAR(bench.state.rotor_speed[0], 700.0, 1e-9);
  EXPECT_EQ(bench.state.rotor_speed[1], 550.0);
  EXPECT_EQ(bench.state.rotor_speed[2], 600.0) << "whose lag holds";
  EXPECT_EQ(bench.state.rotor_speed[3], qdrone2().max_speed);
}

TEST(HeldInputs, WhatIsBeyondTheLimitsComesToThemByItsLagWithARateToo) {
  Bench rate = make_bench(aloft(make_dragging_vehicle()),
                          only({SKYBODY_HELD_ROTOR_LIMIT, SKYBODY_HELD_ROTOR_RATE}));
  Bench lag = make_bench(aloft(make_dragging_vehicle()), only({SKYBODY_HELD_ROTOR_LIMIT}));
  for (Bench* bench : {&rate, &lag}) {
    bench->state.rotor_speed = {1500, 1500, 200, 200};
    bench->state.rotor_command = {1500, 1500, 200, 200};
    bench->state.held[SKYBODY_HELD_ROTOR_LIMIT] = {0, 0, 0, 900, 700, kInfinity, 700, 900};
  }
  rate.state.held[SKYBODY_HELD_ROTOR_RATE] = {1e4, 0.0, -1e4, 0.0};
  for (int k = 0; k < 30; ++k) {
    ASSERT_TRUE(rate.run(1));
    ASSERT_TRUE(lag.run(1));
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(rate.state.rotor_speed[i], lag.state.rotor_speed[i], 1e-9) << i;
    }
  }
}

TEST(HeldInputs, ARateGivesTheThrustOfEveryInstant) {
  const VehicleData d = qdrone2();
  Bench bench = make_bench(aloft(make_vehicle(d)), only({SKYBODY_HELD_ROTOR_RATE}));
  set_speeds(bench, 600.0);
  bench.state.held[SKYBODY_HELD_ROTOR_RATE].assign(4, 1500.0);
  ASSERT_TRUE(bench.run(200));
  // v = 4 k_f / m (w1^3 - w0^3) / (3 rate) - g t; rk4 is exact for a force of second degree.
  const double w0 = 600.0, w1 = 900.0;
  const double expected =
      4.0 * d.kf / d.mass * (w1 * w1 * w1 - w0 * w0 * w0) / (3.0 * 1500.0) - 9.81 * 0.2;
  EXPECT_NEAR(bench.state.u[2], expected, 1e-12);
}

RobotModel make_swinging_vehicle() {
  RobotModel model = make_dragging_vehicle();
  model.bodies.push_back(
      make_body("bob", JointType::kBall, 0, 0.2, {0, 0, -0.5}, diagonal(0.01, 0.01, 0.01)));
  return model;
}

void expect_same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(double)), 0);
}

TEST(HeldInputs, NeutralOnesLeaveEveryBitAsItIs) {
  for (const RobotModel& model : {make_dragging_vehicle(), make_swinging_vehicle()}) {
    for (const IntegratorChoice integrator : kFixedSteps) {
      for (const DynamicsChoice dynamics : {DynamicsChoice::kTree, DynamicsChoice::kSimbody}) {
        Scenario scenario = aloft(model, integrator);
        scenario.stepping.dynamics = dynamics;
        Bench none(scenario), neutral = make_bench(scenario);
        for (Bench* bench : {&none, &neutral}) {
          bench->state.rotor_speed = {600, 700, 800, 900};
          bench->state.rotor_command = {900, 600, 1000, 0};
          for (std::size_t k = 0; k < bench->state.u.size(); ++k) {
            bench->state.u[k] = 0.3 * static_cast<double>(k) - 1.0;
          }
          ASSERT_TRUE(bench->run(50));
        }
        expect_same_bits(none.state.q, neutral.state.q);
        expect_same_bits(none.state.u, neutral.state.u);
        expect_same_bits(none.state.rotor_speed, neutral.state.rotor_speed);
      }
    }
  }
}

/// All held inputs, at random.
void draw_inputs(Random<double>& random, LaneState& state) {
  for (double& v : state.held[SKYBODY_HELD_WIND]) v = random.uniform(-5.0, 5.0);
  for (double& f : state.held[SKYBODY_HELD_WRENCH]) f = random.uniform(-1.0, 1.0);
  for (double& c : state.held[SKYBODY_HELD_BODY_DRAG]) c = random.uniform(0.0, 0.05);
  for (double& g : state.held[SKYBODY_HELD_ROTOR_GAIN]) g = random.uniform(0.0, 2.0);
  for (double& c : state.held[SKYBODY_HELD_ROTOR_FLOW]) c = random.uniform(0.0, 1e-4);
  std::vector<double>& limits = state.held[SKYBODY_HELD_ROTOR_LIMIT];
  for (std::size_t i = 0; i + 1 < limits.size(); i += 2) {
    limits[i] = random.uniform(0.0, 300.0);
    limits[i + 1] = random.uniform(700.0, 1200.0);
  }
  for (double& rate : state.held[SKYBODY_HELD_ROTOR_RATE]) {
    rate = random.uniform() < 0.5 ? kNan : random.uniform(-4000.0, 4000.0);
  }
}

// A plain quadrotor in the air has a separate kernel (HeldInputSet::kAir).
TEST(HeldInputs, TheStepInTheAirHasTheBitsOfAnyHeldStep) {
  RobotModel model = make_dragging_vehicle();
  for (std::size_t i = 0; i < 4; ++i) {  // in rows
    const double x = i < 2 ? 0.15 : -0.15, y = i % 2 == 0 ? 0.2 : -0.2;
    model.rotors[i].set_position({x, y, model.rotors[0].position().z});
    model.rotors[i].direction = x * y > 0.0 ? 1 : -1;
  }
  const Scenario scenario = aloft(model, IntegratorChoice::kMidpoint);
  const Held air = only({SKYBODY_HELD_WIND, SKYBODY_HELD_BODY_DRAG, SKYBODY_HELD_ROTOR_LIMIT});
  Held more = air;
  more[SKYBODY_HELD_WRENCH] = true;
  for (std::size_t i = 0; i < air.size(); ++i) {  // with only some of them
    Held some = air;
    some[i] = false;
    Bench quick = make_bench(scenario, some), any = make_bench(scenario, more);
    const auto kind_of = [](const Bench& bench) {
      return held_input_set(bench.world, FreeRobots(bench.world).robots[0].is_plain_quadrotor);
    };
    ASSERT_EQ(kind_of(quick), HeldInputSet::kAir);
    ASSERT_EQ(kind_of(any), HeldInputSet::kAnything);
    Random<double> random({3, i}, 0, 0, 0);
    draw_inputs(random, quick.state);
    for (Bench* bench : {&quick, &any}) {
      bench->state.rotor_speed = {600, 700, 800, 900};
      bench->state.rotor_command = {900, 600, 1000, 0};
      store(Vec3<double>{0.5, -1.0, 2.0}, bench->state.u.data() + 3);
    }
    for (std::size_t k = 0; k < air.size(); ++k) {
      if (some[k]) any.state.held[k] = quick.state.held[k];
    }
    for (Bench* bench : {&quick, &any}) ASSERT_TRUE(bench->run(200));
    expect_same_bits(quick.state.q, any.state.q);
    expect_same_bits(quick.state.u, any.state.u);
    expect_same_bits(quick.state.rotor_speed, any.state.rotor_speed);
  }
}

TEST(HeldInputs, TreeAndSimbodyAgree) {
  for (std::uint64_t k = 0; k < 100; ++k) {
    Random<double> random{RandomKey{2026, 41}, k, 0, derive_stream("held_inputs_test")};
    RobotModel model = random_tree(random);
    model.rotors = make_dragging_vehicle().rotors;
    model.rotors[3].axis = rotate(random.quaternion(), Vec3<double>{0, 0, 1});
    Bench bench = make_bench(aloft(model));
    const auto simbody = make_simbody_stepper(bench.world);
    random_state(random, bench.world, bench.state.q, bench.state.u);
    if (model.bodies[0].joint.type == JointType::kFree) bench.state.q[2] = 100.0;
    set_speeds(bench, 800.0);
    draw_inputs(random, bench.state);
    if (bench.state.u.empty()) continue;
    std::vector<double> theirs(bench.state.u.size());
    const std::vector<double> ours = accelerations(bench);
    simbody->accelerations(bench.state, theirs.data());
    // Rounding through ill-conditioned trees, see tree_test.cpp.
    EXPECT_LT(largest_difference(ours, theirs), 1e-6 * (1.0 + largest(ours))) << k;
  }
}

TEST(HeldInputs, AFreeRobotFliesAsOnSimbody) {
  for (const IntegratorChoice integrator : kFixedSteps) {
    Random<double> random{RandomKey{2026, 42}, 0, 0, derive_stream("held_inputs_test")};
    Bench bench = make_bench(aloft(make_dragging_vehicle(), integrator));
    const auto simbody = make_simbody_stepper(bench.world);
    set_speeds(bench, 800.0);
    draw_inputs(random, bench.state);
    for (double& f : bench.state.held[SKYBODY_HELD_WRENCH]) f *= 0.02;
    LaneState theirs = bench.state;
    ASSERT_TRUE(bench.run(300));
    for (int i = 0; i < 300; ++i) ASSERT_TRUE(simbody->advance(theirs));
    EXPECT_LT(largest_difference(bench.state.q, theirs.q), 1e-11);
    EXPECT_LT(largest_difference(bench.state.u, theirs.u), 1e-11);
    EXPECT_EQ(bench.state.rotor_speed, theirs.rotor_speed);
  }
}

TEST(HeldInputs, IntegratorsOfSundialsTakeThemToo) {
  for (const IntegratorChoice integrator : {IntegratorChoice::kCvode, IntegratorChoice::kArkode}) {
    Random<double> random{RandomKey{2026, 43}, 0, 0, derive_stream("held_inputs_test")};
    Scenario scenario = aloft(make_dragging_vehicle(), integrator);
    scenario.stepping.solver.method =
        integrator == IntegratorChoice::kCvode ? SolverMethod::kBdf : SolverMethod::kErk;
    Bench bench = make_bench(scenario), exact = make_bench(aloft(make_dragging_vehicle()));
    for (Bench* b : {&bench, &exact}) set_speeds(*b, 800.0);
    draw_inputs(random, bench.state);
    for (double& f : bench.state.held[SKYBODY_HELD_WRENCH]) f *= 0.02;
    exact.state = bench.state;
    ASSERT_TRUE(bench.run(100));
    ASSERT_TRUE(exact.run(100));
    EXPECT_LT(largest_difference(bench.state.u, exact.state.u), 1e-4) << "its tolerance";
    EXPECT_LT(largest_difference(bench.state.rotor_speed, exact.state.rotor_speed), 1e-9);
  }
}

}  // namespace
}  // namespace skybody::test
