// A drawn rotor position: the vehicle flies like one built with that position.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/physics/random_worlds.h"

namespace skybody::test {
namespace {

/// Hubs that differ from make_vehicle()'s: a wider rectangle, another one, at different heights,
/// and anywhere.
enum class Hubs { kWider, kOblong, kUneven, kAnywhere };

Vec3<double> hub_at(Hubs hubs, int rotor, const Vec3<double>& nominal) {
  const Vec3<double> oblong{1.5 * nominal.x, 0.8 * nominal.y, nominal.z + 0.03};
  const Vec3<double> anywhere[4] = {
      {0.1, 0.2, 0.02}, {-0.15, 0.1, 0.03}, {-0.2, -0.12, -0.01}, {0.18, -0.07, 0.0}};
  switch (hubs) {
    case Hubs::kWider:
      return nominal * 1.3;
    case Hubs::kOblong:
      return oblong;
    case Hubs::kUneven:
      return oblong + Vec3<double>{0.0, 0.0, rotor == 2 ? 0.05 : 0.0};
    default:
      return anywhere[rotor];
  }
}

/// A quadrotor of two mirrored pairs, whose rotors have every force.
RobotModel vehicle() {
  RobotModel model = make_vehicle(qdrone2());
  const Vec3<double> rows[4] = {
      {0.2, 0.15, 0.01}, {0.2, -0.15, 0.01}, {-0.2, 0.15, 0.01}, {-0.2, -0.15, 0.01}};
  for (std::size_t i = 0; i < 4; ++i) {
    Rotor& rotor = model.rotors[i];
    rotor.set_position(rows[i]);
    rotor.direction = i == 0 || i == 3 ? 1 : -1;
    rotor.constants[kDragConstant] = 2e-5;
    rotor.constants[kRollingMomentConstant] = 1e-6;
    rotor.constants[kRotorInertia] = 5e-6;
  }
  return model;
}

/// The vehicle with these hubs in its model.
RobotModel built(RobotModel model, Hubs hubs) {
  for (std::size_t i = 0; i < 4; ++i) {
    Rotor& rotor = model.rotors[i];
    rotor.set_position(hub_at(hubs, static_cast<int>(i), rotor.position()));
  }
  return model;
}

/// Sets these hubs in an environment's own values.
void draw(Bench& bench, Hubs hubs) {
  for (int i = 0; i < 4; ++i) {
    const std::string path = "robots.r.rotors[" + std::to_string(i) + "].position[";
    double* p = &bench.param(path + "0]");
    const Vec3<double> hub = hub_at(hubs, i, {p[0], p[1], p[2]});
    ASSERT_EQ(&bench.param(path + "2]"), p + 2);
    p[0] = hub.x;
    p[1] = hub.y;
    p[2] = hub.z;
  }
}

void start(Bench& bench) {
  bench.state.q[2] = 50.0;
  bench.state.u = {3.0, -1.0, 0.5, 0.4, -0.7, 0.2};
  for (std::size_t i = 0; i < 4; ++i) {
    const double step = static_cast<double>(i);
    bench.state.rotor_speed[i] = 900.0 + 40.0 * step;
    bench.state.rotor_command[i] = 1000.0 - 30.0 * step;
  }
}

constexpr Hubs kAll[] = {Hubs::kWider, Hubs::kOblong, Hubs::kUneven, Hubs::kAnywhere};

TEST(RotorMount, ADrawnHubFliesAsOneOfTheModelToTheBit) {
  for (const IntegratorChoice integrator : kFixedSteps) {
    for (const Hubs hubs : kAll) {
      Bench drawn(make_scenario(vehicle(), integrator));
      Bench model(make_scenario(built(vehicle(), hubs), integrator));
      start(drawn);
      start(model);
      draw(drawn, hubs);
      ASSERT_TRUE(drawn.run(200));
      ASSERT_TRUE(model.run(200));
      EXPECT_EQ(drawn.state.q, model.state.q);
      EXPECT_EQ(drawn.state.u, model.state.u);
    }
  }
}

TEST(RotorMount, ADrawnHubAcceleratesAsOnSimbody) {
  for (const Hubs hubs : kAll) {
    Bench bench(make_scenario(vehicle()));
    start(bench);
    const auto simbody = make_simbody_stepper(bench.world);
    std::vector<double> nominal(6), ours(6), theirs(6);
    bench.stepper->accelerations(bench.state, nominal.data());
    draw(bench, hubs);
    bench.stepper->accelerations(bench.state, ours.data());
    simbody->accelerations(bench.state, theirs.data());
    EXPECT_GT(largest_difference(nominal, ours), 1e-2);
    EXPECT_LT(largest_difference(ours, theirs), 1e-12 * largest(ours)) << "a few roundings";
  }
}

TEST(RotorMount, NominalValuesThatWereDrawnLeaveTheBits) {
  Bench drawn(make_scenario(vehicle())), nominal(make_scenario(vehicle()));
  start(drawn);
  start(nominal);
  // A parameter without effect in flight, so that each lane reads its own values.
  drawn.param("contact.friction") = 0.5;
  ASSERT_TRUE(drawn.run(200));
  ASSERT_TRUE(nominal.run(200));
  EXPECT_EQ(drawn.state.q, nominal.state.q);
  EXPECT_EQ(drawn.state.u, nominal.state.u);
}

TEST(RotorMount, DrawnHubsCountForRotorsThatEffectsHold) {
  const auto holds = [](WorldPlan& plan) {
    plan.holds[SKYBODY_HELD_WIND] = plan.holds[SKYBODY_HELD_ROTOR_FLOW] = true;
  };
  for (const Hubs hubs : kAll) {
    Bench drawn(make_scenario(vehicle()), holds);
    Bench model(make_scenario(built(vehicle(), hubs)), holds);
    for (Bench* bench : {&drawn, &model}) {
      start(*bench);
      for (double& flow : bench->state.held[SKYBODY_HELD_ROTOR_FLOW]) flow = 1e-4;
      bench->state.held[SKYBODY_HELD_WIND] = {2.0, -1.0, 0.5};
    }
    draw(drawn, hubs);
    ASSERT_TRUE(drawn.run(200));
    ASSERT_TRUE(model.run(200));
    EXPECT_EQ(drawn.state.q, model.state.q);
    EXPECT_EQ(drawn.state.u, model.state.u);
  }
}

}  // namespace
}  // namespace skybody::test
