// Fast spinning bodies keep their energy and angular momentum at any step size, and gain none by
// contact.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "core/physics/step/step_plan.h"
#include "tests/unit/physics/test_models.h"

namespace skybody::test {
namespace {

constexpr double kSteps[] = {0.00025, 0.001, 0.002, 0.004};

Scenario weightless(Scenario scenario) {
  scenario.constants[kGravity + 2] = 0.0;
  return scenario;
}

/// Kinetic energy of all bodies [J].
double energy(Bench& bench) {
  bench.stepper->update_bodies(bench.state);
  double sum = 0.0;
  for (std::size_t i = 0; i < bench.world.bodies.size(); ++i) {
    sum += kinetic_energy(bench.state.bodies[i], bench.world.bodies[i].model->mass);
  }
  return sum;
}

/// A body, and the direction of its spin in its own axes.
struct Spinner {
  const char* name;
  RobotModel model;
  Vec3<double> spin;
};

std::vector<Spinner> spinners() {
  const SymMat3<double> vehicle = diagonal(0.0147, 0.0169, 0.0294);
  return {{"middle axis", make_free_body(1.54, vehicle), {0.02, 1.0, 0.02}},
          {"oblique", make_free_body(1.54, vehicle), {0.4, 0.5, 0.3}},
          {"offset mass", make_free_body(1.54, vehicle, {0.05, -0.02, 0.03}), {0.3, 1.0, 0.2}},
          {"stick", make_free_body(0.05, diagonal(3.75e-4, 3.75e-4, 8.3e-7)), {0.1, 0.1, 1.0}}};
}

void set_spin(Bench& bench, const Vec3<double>& direction, double speed) {
  const Vec3<double> spin = direction * (speed / norm(direction));
  store(spin, bench.state.u.data() + 3);
}

// Prints a table: relative change of energy in a minute.
TEST(FastSpin, KeepsTheEnergyOfAMinute) {
  for (const Spinner& s : spinners()) {
    for (const double speed : {5.0, 20.0, 100.0, 500.0}) {
      std::printf("%-12s %5g rad/s:", s.name, speed);
      for (const double dt : kSteps) {
        Bench bench(weightless(make_scenario(s.model, IntegratorChoice::kMidpoint, dt)));
        set_spin(bench, s.spin, speed);
        const double before = energy(bench);
        const Vec3<double> momentum = spin_momentum(bench.state.bodies[0], s.model.bodies[0].mass);
        ASSERT_TRUE(bench.run_seconds(60.0));
        const double gain = energy(bench) / before - 1.0;
        std::printf("  %.1e", gain);
        const bool is_fast = speed * speed > fast_spin_square(dt);
        // Torque-free motion keeps both up to rounding: 1e-16 in each of up to 3e6 parts, and up to
        // 450 times as much for the stick's small moment. The explicit rule, below
        // fast_spin_square, gains at most 1 % by its own bound.
        EXPECT_NEAR(gain, 0.0, is_fast ? 1e-9 : 0.01) << s.name << ", " << speed << ", " << dt;
        if (!is_fast) continue;
        const Vec3<double> drift =
            spin_momentum(bench.state.bodies[0], s.model.bodies[0].mass) - momentum;
        EXPECT_LT(norm(drift) / norm(momentum), 1e-9) << s.name << ", " << speed << ", " << dt;
      }
      std::printf("\n");
    }
  }
}

TEST(FastSpin, KeepsTheEnergyWithSemiImplicitEulerAndOnSimbody) {
  for (const Spinner& s : spinners()) {
    for (const double dt : {0.001, 0.004}) {
      Bench euler(weightless(make_scenario(s.model, IntegratorChoice::kSemiImplicitEuler, dt)));
      Scenario by_simbody = weightless(make_scenario(s.model, IntegratorChoice::kMidpoint, dt));
      by_simbody.stepping.dynamics = DynamicsChoice::kSimbody;
      Bench simbody(by_simbody);
      for (Bench* bench : {&euler, &simbody}) {
        set_spin(*bench, s.spin, 100.0);
        const double before = energy(*bench);
        ASSERT_TRUE(bench->run_seconds(5.0));
        // Simbody's accelerations round the inertia about the origin.
        EXPECT_NEAR(energy(*bench) / before, 1.0, 1e-8) << s.name << ", " << dt;
      }
    }
  }
}

/// Attitude and spin after half a second under gravity with running rotors.
std::array<double, 7> fly(IntegratorChoice integrator, double dt, double speed) {
  VehicleData data = qdrone2();
  RobotModel model = make_vehicle(data);
  model.bodies[0].mass.com = {0.01, 0.02, -0.01};
  Bench bench(make_scenario(model, integrator, dt));
  bench.state.q[2] = 1000.0;
  set_spin(bench, {0.4, 0.5, 0.3}, speed);
  for (std::size_t i = 0; i < 4; ++i) {
    bench.state.rotor_speed[i] = bench.state.rotor_command[i] = 900.0 + 100.0 * double(i);
  }
  EXPECT_TRUE(bench.run_seconds(0.5));
  std::array<double, 7> out;
  for (std::size_t k = 0; k < 4; ++k) out[k] = bench.state.q[3 + k];
  for (std::size_t k = 0; k < 3; ++k) out[4 + k] = bench.state.u[3 + k] / speed;
  return out;
}

double distance(const std::array<double, 7>& a, const std::array<double, 7>& b) {
  double sum = 0.0, turned = 0.0;
  for (std::size_t k = 0; k < 4; ++k) turned += a[k] * b[k];
  for (std::size_t k = 4; k < 7; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(sum + 2.0 - 2.0 * std::fabs(turned));
}

TEST(FastSpin, ConvergesWithSecondOrder) {
  for (const double speed : {30.0, 100.0}) {
    const auto exact = fly(IntegratorChoice::kRk4, 1e-5, speed);
    const double dt = 0.04 / speed;  // fast, and one part per half step
    const double steps = std::lround(0.5 / dt);
    const double coarse = distance(fly(IntegratorChoice::kMidpoint, 0.5 / steps, speed), exact);
    const double fine = distance(fly(IntegratorChoice::kMidpoint, 0.25 / steps, speed), exact);
    EXPECT_LT(coarse, 0.1);
    // A quarter; the remaining third-order term is a tenth of it.
    EXPECT_NEAR(coarse / fine, 4.0, 0.6) << speed;
  }
}

TEST(FastSpin, IsThatOfTheTreeAlgorithms) {
  // A second robot with a joint makes the world use the general step for the free robot.
  for (const double dt : kSteps) {
    for (const Spinner& s : spinners()) {
      Scenario alone = make_scenario(s.model, IntegratorChoice::kMidpoint, dt);
      Scenario both = alone;
      RobotUse other;
      other.name = "other";
      other.model = make_free_body(1.0, diagonal(0.01, 0.02, 0.025));
      other.model.bodies.push_back(
          make_body("arm", JointType::kPin, 0, 0.1, {0.1, 0, 0}, diagonal(1e-4, 1e-4, 1e-4)));
      both.robots.push_back(other);
      Bench free(alone), tree(both);
      ASSERT_FALSE(StepPlan(tree.world, DynamicsBackend::kTree).free_robots);
      set_spin(free, s.spin, 300.0);
      set_spin(tree, s.spin, 300.0);
      ASSERT_TRUE(free.run(200) && tree.run(200));
      // Roundings of different sums, amplified a thousand times by the tumbling of 200 steps.
      for (std::size_t k = 0; k < 7; ++k) {
        EXPECT_NEAR(free.state.q[k], tree.state.q[k], 1e-9) << s.name;
      }
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(free.state.u[k], tree.state.u[k], 1e-7) << s.name;
      }
    }
  }
}

TEST(FastSpin, ARobotWithAnArmKeepsItsEnergy) {
  for (const JointType joint :
       {JointType::kWeld, JointType::kPin, JointType::kSlider, JointType::kBall}) {
    RobotModel model = make_free_body(1.0, diagonal(0.0147, 0.0169, 0.0294), {0.01, 0, 0.02});
    model.bodies.push_back(
        make_body("arm", joint, 0, 0.02, {0, 0.1, -0.1}, diagonal(8e-5, 8.2e-5, 1e-5)));
    model.bodies[1].joint.frame_in_parent.position = {0.05, 0.02, -0.03};
    for (const double dt : kSteps) {
      Bench bench(weightless(make_scenario(model, IntegratorChoice::kMidpoint, dt)));
      set_spin(bench, {0.1, 0.2, 0.97}, 100.0);
      const double before = energy(bench);
      double most = 0.0;
      for (double time = 0.0; time < 2.0; time += dt) {
        ASSERT_TRUE(bench.run(1));
        most = std::fmax(most, std::fabs(energy(bench) / before - 1.0));
      }
      // Rigid: up to rounding. A whirling arm: the error of integration in parts of 0.015 rad, with
      // changing sign.
      EXPECT_LT(most, joint == JointType::kWeld ? 1e-11 : 2e-4)
          << static_cast<int>(joint) << ", " << dt;
    }
  }
}

/// Largest relative change of a tree's energy while it tumbles freely.
double energy_change(const RobotModel& model, double dt, double speed, int seconds) {
  Bench bench(weightless(make_scenario(model, IntegratorChoice::kMidpoint, dt)));
  set_spin(bench, {0.3, 1.0, 0.2}, speed);
  const double before = energy(bench);
  double most = 0.0;
  for (int second = 0; second < seconds; ++second) {
    EXPECT_TRUE(bench.run_seconds(1.0));
    most = std::fmax(most, std::fabs(energy(bench) / before - 1.0));
  }
  return most;
}

// An arm that swings freely about a hinge while the base tumbles.
TEST(FastSpin, AHingedArmKeepsTheEnergyOfAMinute) {
  for (const double mass : {0.3, 0.01}) {
    RobotModel model = make_free_body(1.0, diagonal(0.01, 0.012, 0.02));
    model.bodies.push_back(
        make_body("arm", JointType::kPin, 0, mass, {0.0, 0.0, 0.2}, diagonal(0.002, 0.002, 1e-4)));
    model.bodies[1].joint.frame_in_parent.position = {0.05, 0.0, 0.0};
    for (const double dt : {0.001, 0.004}) {
      for (const double speed : {100.0, 500.0}) {
        EXPECT_LT(energy_change(model, dt, speed, 60), 1e-5)
            << mass << " kg, " << speed << " rad/s, " << dt;
      }
    }
  }
}

/// A chain of links of 50 g with crossed hinges or universal joints.
RobotModel chain(JointType joint, int links) {
  const bool has_hinges = joint == JointType::kPin;
  const Vec3<double> along = has_hinges ? Vec3<double>{0.1, 0.0, 0.0} : Vec3<double>{0.0, 0.0, 0.1};
  const SymMat3<double> inertia =
      has_hinges ? diagonal(1e-5, 5e-5, 5e-5) : diagonal(5e-5, 5e-5, 1e-5);
  RobotModel model = make_free_body(1.0, diagonal(0.01, 0.012, 0.02));
  for (int i = 0; i < links; ++i) {
    model.bodies.push_back(make_body("link", joint, i, 0.05, 0.5 * along, inertia));
    model.bodies.back().name += std::to_string(i);
    Pose& frame = model.bodies.back().joint.frame_in_parent;
    frame.position = (i == 0 ? 0.5 : 1.0) * along;
    if (has_hinges)
      frame.rotation = normalized(Quat<double>{1.0, i % 2 == 0 ? 1.0 : -1.0, 0.0, 0.0});
  }
  return model;
}

/// Attitude of the base, and the angle of the first of four links, after 0.1 s of free tumbling.
std::array<double, 5> tumble(IntegratorChoice integrator, double dt) {
  Bench bench(weightless(make_scenario(chain(JointType::kPin, 4), integrator, dt)));
  set_spin(bench, {0.3, 1.0, 0.2}, 60.0);
  EXPECT_TRUE(bench.run_seconds(0.096));
  const double* q = bench.state.q.data();
  return {q[3], q[4], q[5], q[6], q[7]};
}

// A step has five substeps at both time steps (at least 2 and at most 5 are wanted), so that they
// shrink with it, and nothing acts but the joints.
TEST(FastSpin, SubstepsOfAChainConvergeWithFourthOrder) {
  const auto exact = tumble(IntegratorChoice::kRk4, 1e-5);
  const auto error = [&](double dt) {
    const auto end = tumble(IntegratorChoice::kMidpoint, dt);
    double sum = 0.0;
    for (std::size_t k = 0; k < end.size(); ++k) sum += (end[k] - exact[k]) * (end[k] - exact[k]);
    return std::sqrt(sum);
  };
  const double coarse = error(1.6e-3), fine = error(8e-4);
  std::printf("error %.2e, at half the step %.2e\n", coarse, fine);
  // A sixteenth, where a rule of order 2 gives a fourth; the iteration in a substep ends at 1e-9,
  // which is a third of the finer error.
  EXPECT_NEAR(coarse / fine, 16.0, 4.0);
}

// A minute of four links at 500 rad/s changes it by 7e-4 (at 1 ms and at 4 ms).
TEST(FastSpin, AChainKeepsItsEnergy) {
  for (const double dt : {0.001, 0.004}) {
    EXPECT_LT(energy_change(chain(JointType::kPin, 4), dt, 100.0, 10), 1e-4) << dt;
    EXPECT_LT(energy_change(chain(JointType::kPin, 4), dt, 500.0, 4), 1e-3) << dt;
    EXPECT_LT(energy_change(chain(JointType::kUniversal, 2), dt, 100.0, 10), 1e-5) << dt;
    EXPECT_LT(energy_change(chain(JointType::kUniversal, 2), dt, 500.0, 4), 1e-4) << dt;
  }
}

RobotModel make_stick() {
  RobotModel model = make_free_body(0.05, diagonal(3.75e-4, 3.75e-4, 8.3e-7));
  model.bodies[0].collisions.push_back(make_capsule(0.005, 0.28));
  return model;
}

// A contact at the stick's side spins it up about its long axis to 1200 rad/s.
TEST(FastSpin, AStickThatTheGroundSpinsUpGainsNothing) {
  for (const double dt : kSteps) {
    Bench bench(make_scenario(make_stick(), IntegratorChoice::kMidpoint, dt));
    const double weight = 0.05 * 9.81;
    bench.state.q[2] = 0.02;
    store(normalized(Quat<double>{0.7071, 0.01, 0.7271, 0.01}), bench.state.q.data() + 3);
    bench.state.u[1] = 10.0;
    bench.state.u[2] = -2.0;
    const double before = energy(bench) + weight * bench.state.q[2];
    double fastest = 0.0;
    for (double time = 0.0; time < 0.6; time += dt) {
      ASSERT_TRUE(bench.run(1)) << dt << ", at " << time;
      // The contact's springs hold the rest.
      EXPECT_LT(energy(bench) + weight * bench.state.q[2], 1.0001 * before) << dt;
      fastest = std::fmax(fastest, std::fabs(bench.state.u[5]));
    }
    EXPECT_GT(fastest, 500.0) << "the throw spins it up";
  }
}

TEST(FastSpin, SticksThrownAtAWallGainNothing) {
  for (const double dt : kSteps) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    std::normal_distribution<double> normal;
    for (int k = 0; k < 128; ++k) {
      Scenario scenario = weightless(make_scenario(make_stick(), IntegratorChoice::kMidpoint, dt));
      Obstacle wall;
      wall.name = "wall";
      wall.shape = make_box(0.02, 40.0, 40.0);
      wall.shape.pose.position = {0.6, 0.0, 0.0};
      scenario.obstacles.push_back(wall);
      Bench bench(scenario);
      Quat<double> turn;
      turn.w = normal(random);
      turn.x = normal(random);
      turn.y = normal(random);
      turn.z = normal(random);
      bench.state.q = {0.2, 0.0, 10.0, 0.0, 0.0, 0.0, 0.0};
      store(normalized(turn), bench.state.q.data() + 3);
      const double speed = 30.0 + 10.0 * any(random);
      for (std::size_t i = 0; i < 6; ++i) {
        bench.state.u[i] = (i < 3 ? 0.5 * speed : 5.0) * any(random);
      }
      bench.state.u[0] = speed;
      const double before = energy(bench);
      ASSERT_TRUE(bench.run_seconds(1.0)) << k << ", " << dt;
      // Springs store energy during contact and never release more than they stored; the error of
      // an explicit contact of several parts is 1e-4.
      EXPECT_LT(energy(bench), 1.0001 * before) << k << ", " << dt;
    }
  }
}

}  // namespace
}  // namespace skybody::test
