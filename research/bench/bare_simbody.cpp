// Hand-written loops over Simbody, in C++17 as its headers require.
#include "research/bench/bare_simbody.h"

#include <Simbody.h>

#include <algorithm>
#include <cmath>

namespace skybody::bench {
namespace {

using SimTK::Vec3;

/// Rotor speeds of the hand-written loops.
struct Rotors {
  double speed[4] = {kHover.start, kHover.start, kHover.start, kHover.start};
  double up = std::exp(-kHover.dt / kHover.tau_up), down = std::exp(-kHover.dt / kHover.tau_down);

  /// Moves the rotors to the end of the step. Thrust and torque in body axes, from the mean of the
  /// squared speed over the step (rotor_over_step in core/physics/forces/rotor_lag.h).
  SimTK::SpatialVec step() {
    SimTK::SpatialVec sum(Vec3(0), Vec3(0));
    for (int i = 0; i < 4; ++i) {
      const double command = std::clamp(kHover.command, 0.0, kHover.max_speed);
      const double start = speed[i], gap = command - start;
      const double decay = gap > 0.0 ? up : down, tau = gap > 0.0 ? kHover.tau_up : kHover.tau_down;
      speed[i] = command - gap * decay;
      const double lacking = gap * (0.5 * tau / kHover.dt * (1.0 - decay));
      const double squared = command * command - lacking * (2.0 * command + start + speed[i]);
      const Vec3 thrust(0, 0, kHover.kf * squared);
      sum[0] += Vec3(kHover.hub[i][0], kHover.hub[i][1], 0) % thrust;
      sum[0][2] -= kHover.direction[i] * kHover.km * squared;
      sum[1] += thrust;
    }
    return sum;
  }
};

/// The hand-written loops.
class Bare : public BareLoop {
 public:
  explicit Bare(bool with_operator) : matter_(system_), operator_(with_operator) {
    if (!operator_) {
      forces_ = std::make_unique<SimTK::GeneralForceSubsystem>(system_);
      forces_->setNumberOfThreads(1);
      const SimTK::Force::Gravity gravity(*forces_, matter_, Vec3(0, 0, -kHover.g));
      discrete_ = std::make_unique<SimTK::Force::DiscreteForces>(*forces_, matter_);
    }
    const SimTK::Inertia inertia(kHover.inertia[0], kHover.inertia[1], kHover.inertia[2]);
    SimTK::Body::Rigid rigid(SimTK::MassProperties(kHover.mass, Vec3(0), inertia));
    body_ = SimTK::MobilizedBody::Free(matter_.updGround(), rigid);
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
    state_.updQ()[6] = kHover.height;
    body_forces_.resize(2);
    body_forces_ = SimTK::SpatialVec(Vec3(0), Vec3(0));
    mobility_forces_.resize(6);
    mobility_forces_ = 0.0;
  }

  void step() override {
    const SimTK::SpatialVec wrench = rotors_.step();
    drift_half();
    start_ = state_.getU();
    accelerate(wrench);
    state_.updU() = start_ + 0.5 * kHover.dt * udot_;
    accelerate(wrench);
    state_.updU() = start_ + kHover.dt * udot_;
    drift_half();
  }
  double height() const override { return state_.getQ()[6]; }

  void rebuild(double scale) override {
    const SimTK::Inertia inertia(kHover.inertia[0], kHover.inertia[1], kHover.inertia[2]);
    body_.setDefaultMassProperties(
        SimTK::MassProperties(scale * kHover.mass, Vec3(0), scale * inertia));
    state_ = system_.realizeTopology();
    system_.realizeModel(state_);
    state_.updQ()[6] = kHover.height;
    system_.realize(state_, SimTK::Stage::Velocity);
  }

 private:
  void drift_half() {
    system_.realize(state_, SimTK::Stage::Position);
    matter_.multiplyByN(state_, false, state_.getU(), qdot_);
    state_.updQ() += 0.5 * kHover.dt * qdot_;
    system_.realize(state_, SimTK::Stage::Time);
    matter_.normalizeQuaternions(state_);
  }

  void accelerate(const SimTK::SpatialVec& wrench) {
    system_.realize(state_, operator_ ? SimTK::Stage::Dynamics : SimTK::Stage::Velocity);
    const SimTK::Rotation& r = body_.getBodyRotation(state_);
    body_forces_[1] = SimTK::SpatialVec(r * wrench[0], r * wrench[1]);
    if (operator_) {
      body_forces_[1][1][2] -= kHover.mass * kHover.g;
      matter_.calcAccelerationIgnoringConstraints(state_, mobility_forces_, body_forces_, udot_,
                                                  body_accelerations_);
    } else {
      discrete_->setOneBodyForce(state_, body_, body_forces_[1]);
      system_.realize(state_, SimTK::Stage::Acceleration);
      udot_ = state_.getUDot();
    }
  }

  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  bool operator_;
  std::unique_ptr<SimTK::GeneralForceSubsystem> forces_;
  std::unique_ptr<SimTK::Force::DiscreteForces> discrete_;
  SimTK::MobilizedBody::Free body_;
  SimTK::State state_;
  SimTK::Vector_<SimTK::SpatialVec> body_forces_, body_accelerations_;
  SimTK::Vector mobility_forces_, start_, udot_, qdot_;
  Rotors rotors_;
};

}  // namespace

std::unique_ptr<BareLoop> make_bare_loop(bool with_operator) {
  return std::make_unique<Bare>(with_operator);
}

}  // namespace skybody::bench
