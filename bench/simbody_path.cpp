// What the engine costs on top of Simbody: our Stepper beside two hand-written loops over Simbody
// of the same hover world (a QDrone2 in the air, four rotors with lag, gravity, semi-implicit Euler
// at 1 ms), all in one run, taking turns. Exit code 1 if the three end in different places.
//
//   bare, forces     Force::Gravity and Force::DiscreteForces, realize(Acceleration): the usual way
//   bare, operator   forces handed to calcAccelerationIgnoringConstraints: the quick way
#include <Simbody.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/physics/default_state.h"
#include "core/physics/stepper.h"

namespace {

using SimTK::Real;
using SimTK::Vec3;

constexpr double kDt = 0.001, kMass = 1.54, kG = 9.81;
constexpr double kKf = 1.9533e-6, kKm = 2.8401e-8, kTauUp = 0.0125, kTauDown = 0.025;
constexpr double kMaxSpeed = 2246.0;
constexpr double kInertia[3] = {0.0147, 0.0169, 0.0294};
constexpr double kHub[4][2] = {{0.1, 0.12}, {0.1, -0.12}, {-0.1, 0.12}, {-0.1, -0.12}};
constexpr int kDirection[4] = {1, -1, -1, 1};
constexpr double kCommand[4] = {1391.0, 1391.0, 1391.0, 1391.0};  // a little above hover
constexpr int kSteps = 20000, kTrials = 15;

/// Rotor speeds of the hand-written loops.
struct Rotors {
  double speed[4] = {1390.0, 1390.0, 1390.0, 1390.0};
  double half_up = std::exp(-0.5 * kDt / kTauUp), full_up = std::exp(-kDt / kTauUp);
  double half_down = std::exp(-0.5 * kDt / kTauDown), full_down = std::exp(-kDt / kTauDown);

  /// Thrust and torque in body axes with the rotors in mid-step; then moves them to its end.
  SimTK::SpatialVec step() {
    SimTK::SpatialVec sum(Vec3(0), Vec3(0));
    for (int i = 0; i < 4; ++i) {
      const double command = std::clamp(kCommand[i], 0.0, kMaxSpeed);
      const bool up = command > speed[i];
      const double half = command + (speed[i] - command) * (up ? half_up : half_down);
      speed[i] = command + (speed[i] - command) * (up ? full_up : full_down);
      const Vec3 thrust(0, 0, kKf * half * half);
      sum[0] += Vec3(kHub[i][0], kHub[i][1], 0) % thrust;
      sum[0][2] -= kDirection[i] * kKm * half * half;
      sum[1] += thrust;
    }
    return sum;
  }
};

/// The hand-written loops.
class Bare {
 public:
  explicit Bare(bool with_operator) : matter_(system_), operator_(with_operator) {
    if (!operator_) {
      forces_ = std::make_unique<SimTK::GeneralForceSubsystem>(system_);
      forces_->setNumberOfThreads(1);
      SimTK::Force::Gravity(*forces_, matter_, Vec3(0, 0, -kG));
      discrete_ = std::make_unique<SimTK::Force::DiscreteForces>(*forces_, matter_);
    }
    const SimTK::Inertia inertia(kInertia[0], kInertia[1], kInertia[2]);
    SimTK::Body::Rigid rigid(SimTK::MassProperties(kMass, Vec3(0), inertia));
    body_ = SimTK::MobilizedBody::Free(matter_.updGround(), rigid);
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
    state_.updQ()[6] = 5.0;
    body_forces_.resize(2);
    body_forces_ = SimTK::SpatialVec(Vec3(0), Vec3(0));
    mobility_forces_.resize(6);
    mobility_forces_ = 0.0;
  }

  void step() {
    system_.realize(state_, operator_ ? SimTK::Stage::Dynamics : SimTK::Stage::Velocity);
    const SimTK::Rotation& r = body_.getBodyRotation(state_);
    const SimTK::SpatialVec wrench = rotors_.step();
    body_forces_[1] = SimTK::SpatialVec(r * wrench[0], r * wrench[1]);
    if (operator_) {
      body_forces_[1][1][2] -= kMass * kG;
      matter_.calcAccelerationIgnoringConstraints(state_, mobility_forces_, body_forces_, udot_,
                                                  body_accelerations_);
    } else {
      discrete_->setOneBodyForce(state_, body_, body_forces_[1]);
      system_.realize(state_, SimTK::Stage::Acceleration);
      udot_ = state_.getUDot();
    }
    state_.updU() += kDt * udot_;
    system_.realize(state_, SimTK::Stage::Position);
    matter_.multiplyByN(state_, false, state_.getU(), qdot_);
    state_.updQ() += kDt * qdot_;
    system_.realize(state_, SimTK::Stage::Time);
    matter_.normalizeQuaternions(state_);
  }
  double height() const { return state_.getQ()[6]; }

 private:
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  bool operator_;
  std::unique_ptr<SimTK::GeneralForceSubsystem> forces_;
  std::unique_ptr<SimTK::Force::DiscreteForces> discrete_;
  SimTK::MobilizedBody::Free body_;
  SimTK::State state_;
  SimTK::Vector_<SimTK::SpatialVec> body_forces_, body_accelerations_;
  SimTK::Vector mobility_forces_, udot_, qdot_;
  Rotors rotors_;
};

skybody::Scenario make_hover() {
  skybody::Body base;
  base.name = "base";
  base.mass = {kMass, {0, 0, 0}, {kInertia[0], kInertia[1], kInertia[2], 0, 0, 0}};
  skybody::Shape box;
  box.type = skybody::ShapeType::kBox;
  box.size = {0.3, 0.3, 0.1};
  base.collisions.push_back(box);
  skybody::RobotUse robot;
  robot.name = "quad";
  robot.pose.position = {0, 0, 5};
  robot.rotor_speed = 1390.0;
  robot.model.bodies.push_back(base);
  for (int i = 0; i < 4; ++i) {
    skybody::Rotor rotor;
    rotor.position = {kHub[i][0], kHub[i][1], 0};
    rotor.direction = kDirection[i];
    rotor.thrust_constant = kKf;
    rotor.moment_constant = kKm;
    rotor.max_speed = kMaxSpeed;
    rotor.tau_up = kTauUp;
    rotor.tau_down = kTauDown;
    robot.model.rotors.push_back(rotor);
  }
  skybody::Scenario scenario;
  scenario.robots.push_back(robot);
  return scenario;
}

/// The engine's loop over the same world.
class Engine {
 public:
  Engine() : world_(make_hover()), stepper_(skybody::make_simbody_stepper(world_)) {
    skybody::write_default_state(world_, state_);
    state_.rotor_command.assign(kCommand, kCommand + 4);
  }
  void step() { ok_ = stepper_->advance(state_) && ok_; }
  double height() const { return ok_ ? state_.q[2] : -1.0; }

 private:
  skybody::World world_;
  std::unique_ptr<skybody::Stepper> stepper_;
  skybody::LaneState state_;
  bool ok_ = true;
};

/// @returns nanoseconds a step, and where the vehicle ended
template <class Loop>
double measure(Loop& loop, double& height) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kSteps; ++i) loop.step();
  const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - start;
  height = loop.height();
  return time.count() / kSteps;
}

}  // namespace

int main() {
  double best[3] = {1e300, 1e300, 1e300}, height[3] = {};
  for (int trial = 0; trial < kTrials; ++trial) {
    Bare forces(false), with_operator(true);
    Engine engine;
    best[0] = std::min(best[0], measure(forces, height[0]));
    best[1] = std::min(best[1], measure(with_operator, height[1]));
    best[2] = std::min(best[2], measure(engine, height[2]));
  }
  std::printf("one hovering QDrone2, semi-implicit Euler at 1 ms, best of %d x %d steps\n", kTrials,
              kSteps);
  std::printf("  bare, forces     %7.0f ns a step\n", best[0]);
  std::printf("  bare, operator   %7.0f ns a step\n", best[1]);
  std::printf("  engine           %7.0f ns a step = %.2f of the first, %.2f of the second\n",
              best[2], best[2] / best[0], best[2] / best[1]);
  const bool agree =
      std::fabs(height[0] - height[2]) < 1e-6 && std::fabs(height[1] - height[2]) < 1e-6;
  if (!agree) std::printf("they disagree: %.9f %.9f %.9f m\n", height[0], height[1], height[2]);
  return agree ? 0 : 1;
}
