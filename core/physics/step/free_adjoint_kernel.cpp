// The adjoint of steps of one free robot with level rotors (free_robot_adjoint.h), pack by pack.
#include "core/physics/step/adjoint_kernel.h"
#include "core/physics/step/free_robot_adjoint.h"
#include "core/physics/step/group_kernels.h"
#include "core/physics/step/torque_free_adjoint.h"

namespace skybody {
namespace {

/// Half a step at constant velocities (FreeMotion::drift, drift_and_stretch), and its adjoint.
template <class Real>
struct SlowDrift {
  static constexpr bool kLeavesSpin = true;  ///< the rates include the effect of the body's own
                                             ///< spin

  /// Arguments at the half step's start. @param is_last  it is the second half of the step
  SKYBODY_INLINE SlowDrift(const FreeRobotConstants<Real>&, double half, const MaskOf<Real>&,
                           const Quat<Real>& start, const Vec3<Real>& v, const Vec3<Real>& w,
                           bool is_last)
      : velocity(v), spin(w), before(start), turn(w, half, is_last), half_step(half) {
    rotation = start * turn.factor();
    if (!is_last) return;
    inverse_norm = 1.0 / sqrt(squared_norm(rotation));
    rotation = {rotation.w * inverse_norm, rotation.x * inverse_norm, rotation.y * inverse_norm,
                rotation.z * inverse_norm};
  }

  SKYBODY_INLINE void pull_back(const Vec3<Real>& to_position, Quat<Real>& to_rotation,
                                Vec3<Real>& to_velocity, Vec3<Real>& to_spin) const {
    to_velocity += to_position * Real(half_step);
    to_rotation = turn.pull_back(before, pull_back_norm(to_rotation), to_spin);
  }

  Quat<Real> rotation;  ///< at the end
  Vec3<Real> velocity, spin;

 private:
  SKYBODY_INLINE Quat<Real> pull_back_norm(const Quat<Real>& to) const {
    return turn.stretches ? skybody::pull_back_norm(to, rotation, inverse_norm) : to;
  }

  Quat<Real> before;
  RotationIncrement<Real> turn;
  double half_step;
  Real inverse_norm = Real(1.0);
};

/// The same for lanes that spin fast: torque-free motion.
template <class Real>
struct FastDrift : TorqueFreeAdjoint<Real> {
  static constexpr bool kLeavesSpin = false;

  SKYBODY_INLINE FastDrift(const FreeRobotConstants<Real>& c, double half, const MaskOf<Real>& mask,
                           const Quat<Real>& start, const Vec3<Real>& v, const Vec3<Real>& w, bool)
      : TorqueFreeAdjoint<Real>(c.inertia, c.com, Real(half), mask, start, v, w) {}
};

template <class Real>
class FreeAdjointLanes {
 public:
  SKYBODY_INLINE FreeAdjointLanes(const StepCall& call, int first, double* adjoints)
      : plan_(*call.plan),
        group_(*call.group),
        robot_(plan_.free_robots->robots[0]),
        first_(first),
        params_(group_.params + first),
        lags_(LaneValues<Real>(call.derived + first) + plan_.derived.lags),
        factors_(LaneValues<Real>(call.derived + first) + plan_.derived.factors),
        constants_(LaneValues<Real>(call.derived + first) + plan_.derived.bodies),
        to_q_(adjoints + first),
        to_u_(adjoints + (group_.u - group_.q) + first),
        to_speed_(adjoints + (group_.rotor_speed - group_.q) + first),
        to_command_(adjoints + (group_.rotor_command - group_.q) + first) {}

  /// Adjoint of the step of the lanes in `mask`.
  SKYBODY_INLINE void pull_back(const MaskOf<Real>& mask) const {
    const Vec3<Real> spin = load_vec3(LaneValues<Real>(group_.u + first_) + 3);
    const auto is_fast = squared_norm(spin) > plan_.fast_square;
    const auto slow = logical_and(mask, logical_not(is_fast));
    const auto fast = logical_and(mask, is_fast);
    if (any(slow)) pull_back<SlowDrift<Real>>(slow);
    if (any(fast)) pull_back<FastDrift<Real>>(fast);
  }

 private:
  /// @tparam Drift  moves the robot for half a step before and after its velocities change
  template <class Drift>
  SKYBODY_INLINE void pull_back(const MaskOf<Real>& mask) const {
    const double dt = plan_.world.scenario.stepping.dt, half = 0.5 * dt;
    const int rotors = robot_.rotors.count;
    const FreeRobotConstants<Real> c{load_sym_mat3(constants_ + kBodyInertia),
                                     load_sym_mat3(constants_ + kBodyInverseInertia),
                                     constants_[kBodyInverseMass],
                                     factors_[kHeightFactor],
                                     load_vec3(constants_ + kBodyCom),
                                     plan_.free_robots->rate};
    const Vec3<Real> gravity =
        load_vec3(params_ + plan_.world.layout.world_params + kGravity) +
        load_vec3(params_ + robot_.constants + kDisturbanceForce) * c.inverse_mass;

    // Repeats the step, as far as its values are needed.
    LevelSums<Real> sums;
    for (int i = 0; i < rotors; ++i) add_rotor(i, sums);
    const LaneValues<Real> q(group_.q + first_), u(group_.u + first_);
    const Drift begin(c, half, mask, load_quat(q + 3), load_vec3(u), load_vec3(u + 3), false);
    const Mat3<Real> axes = to_mat3(begin.rotation);
    const Vec3<Real> air = transpose_times(axes, begin.velocity);
    using Rates = FreeRatesAdjoint<Real, Drift::kLeavesSpin>;
    const Rates early(c, sums, air, begin.spin);
    const Vec3<Real> late_air = air + (early.in_body + transpose_times(axes, gravity)) * Real(half);
    const Vec3<Real> late_spin = begin.spin + early.spin_rate * Real(half);
    const Rates late(c, sums, late_air, late_spin);
    const Vec3<Real> end_velocity = begin.velocity + (axes * late.in_body + gravity) * Real(dt);
    const Drift end(c, half, mask, begin.rotation, end_velocity,
                    begin.spin + late.spin_rate * Real(dt), true);

    // Backwards.
    const Vec3<Real> to_position = load_vec3(LaneValues<Real>(to_q_));
    Quat<Real> to_rotation = load_quat(LaneValues<Real>(to_q_) + 3);
    Vec3<Real> to_velocity = load_vec3(LaneValues<Real>(to_u_));
    Vec3<Real> to_spin = load_vec3(LaneValues<Real>(to_u_) + 3);
    end.pull_back(to_position, to_rotation, to_velocity, to_spin);
    Mat3<Real> to_axes = outer(to_velocity * Real(dt), late.in_body);
    LevelSums<Real> to_sums;
    const Real zero(0.0);
    Vec3<Real> to_late_air{zero, zero, zero}, to_late_spin{zero, zero, zero};
    late.pull_back(transpose_times(axes, to_velocity) * Real(dt), to_spin * Real(dt), to_late_air,
                   to_late_spin, to_sums);
    to_axes = to_axes + outer(gravity * Real(half), to_late_air);
    to_spin += to_late_spin;
    Vec3<Real> to_air = to_late_air;
    early.pull_back(to_late_air * Real(half), to_late_spin * Real(half), to_air, to_spin, to_sums);
    to_velocity += axes * to_air;
    to_axes = to_axes + outer(begin.velocity, to_air);
    to_rotation = sum(to_rotation, pull_back_axes(begin.rotation, to_axes));
    begin.pull_back(to_position, to_rotation, to_velocity, to_spin);
    put(to_q_, 3, to_rotation.w, mask);
    put(to_q_, 4, to_rotation.x, mask);
    put(to_q_, 5, to_rotation.y, mask);
    put(to_q_, 6, to_rotation.z, mask);
    put(to_u_, 0, to_velocity, mask);
    put(to_u_, 3, to_spin, mask);
    for (int i = 0; i < rotors; ++i) pull_back_rotor(i, to_sums, mask);
  }

  SKYBODY_INLINE RotorOverStep<Real> rotor(int i) const {
    return {load_lag<Real>(lags_ + kLagSize * i), LaneValues<Real>(group_.rotor_speed + first_)[i],
            LaneValues<Real>(group_.rotor_command + first_)[i],
            factors_[kRotorFactorCount * i + kSpeedLimit]};
  }

  SKYBODY_INLINE void add_rotor(int i, LevelSums<Real>& s) const {
    const auto f = factors_ + kRotorFactorCount * i;
    const RotorOverStep<Real> r = rotor(i);
    for (int k = 0; k < 3; ++k) s.thrust[k] += f[kThrustFactor + k] * r.squared;
    s.moment += f[kMomentFactor] * r.squared;
    for (int k = 0; k < 4; ++k) s.drag[k] += f[kDragFactor + k] * r.mean;
    for (int k = 0; k < 3; ++k) s.rolling[k] += f[kRollingFactor + k] * r.mean;
    s.momentum += f[kInertiaFactor] * r.mean;
    s.spin_up += f[kInertiaFactor] * (r.end - r.speed);
  }

  SKYBODY_INLINE void pull_back_rotor(int i, const LevelSums<Real>& to,
                                      const MaskOf<Real>& mask) const {
    const auto f = factors_ + kRotorFactorCount * i;
    Real to_squared = f[kMomentFactor] * to.moment, to_mean = f[kInertiaFactor] * to.momentum;
    for (int k = 0; k < 3; ++k) to_squared += f[kThrustFactor + k] * to.thrust[k];
    for (int k = 0; k < 4; ++k) to_mean += f[kDragFactor + k] * to.drag[k];
    for (int k = 0; k < 3; ++k) to_mean += f[kRollingFactor + k] * to.rolling[k];
    Real to_speed, to_command;
    rotor(i).pull_back(to_squared, to_mean, f[kInertiaFactor] * to.spin_up,
                       LaneValues<Real>(to_speed_)[i], to_speed, to_command);
    put(to_speed_, i, to_speed, mask);
    put(to_command_, i, LaneValues<Real>(to_command_)[i] + to_command, mask);
  }

  static SKYBODY_INLINE void put(double* block, int k, const Real& x, const MaskOf<Real>& mask) {
    store_lanes(block + k * kLaneStride<Real>, x, mask);
  }
  static SKYBODY_INLINE void put(double* block, int k, const Vec3<Real>& v,
                                 const MaskOf<Real>& mask) {
    put(block, k, v.x, mask);
    put(block, k + 1, v.y, mask);
    put(block, k + 2, v.z, mask);
  }

  const StepPlan& plan_;
  const GroupBlocks& group_;
  const FreeRobot& robot_;
  int first_;
  LaneValues<Real> params_, lags_, factors_, constants_;
  double *to_q_, *to_u_, *to_speed_, *to_command_;
};

struct FreeAdjoint {
  template <int W>
  static SKYBODY_INLINE void run(const StepCall& call, std::uint32_t lanes, double* adjoints) {
    using Real = RealOf<W>;
    each_pack<W>(lanes, [&](int first, std::uint32_t bits) SKYBODY_INLINE_LAMBDA {
      FreeAdjointLanes<Real>(call, first, adjoints).pull_back(mask_from_bits<Real>(bits));
      return bits;
    });
  }
};

}  // namespace

bool has_free_adjoint(const StepPlan& plan) {
  if (!plan.free_robots || plan.has_held()) return false;
  const std::vector<FreeRobot>& robots = plan.free_robots->robots;
  return robots.size() == 1 && robots[0].rotors.is_level && robots[0].sites.empty() &&
         plan.world.scenario.stepping.integrator == IntegratorChoice::kMidpoint;
}

AdjointKernel* free_adjoint_kernel(Isa isa) { return kernel<FreeAdjoint>(isa); }

}  // namespace skybody
