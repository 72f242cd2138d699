// The adjoint of steps of one free robot with level rotors (free_robot_adjoint.h), pack by pack.
#include "core/physics/step/adjoint_kernel.h"
#include "core/physics/step/free_robot_adjoint.h"
#include "core/physics/step/group_kernels.h"

namespace skybody {
namespace {

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

  SKYBODY_INLINE void pull_back(const MaskOf<Real>& mask) const {
    const double dt = plan_.world.scenario.stepping.dt, half = 0.5 * dt;
    const int rotors = robot_.rotors.count;
    const typename FreeRatesAdjoint<Real>::Constants c{
        load_sym_mat3(constants_ + kBodyInertia),
        load_sym_mat3(constants_ + kBodyInverseInertia),
        constants_[kBodyInverseMass],
        factors_[kHeightFactor],
        load_vec3(constants_ + kBodyCom),
        plan_.free_robots->rate};
    const Vec3<Real> gravity =
        load_vec3(params_ + plan_.world.layout.world_params + kGravity) +
        load_vec3(params_ + robot_.constants + kDisturbanceForce) * c.inverse_mass;

    // The step once more, up to where it leaves no more to know.
    LevelSums<Real> sums;
    for (int i = 0; i < rotors; ++i) add_rotor(i, sums);
    const LaneValues<Real> q(group_.q + first_), u(group_.u + first_);
    const Quat<Real> start = load_quat(q + 3);
    const Vec3<Real> velocity = load_vec3(u), spin = load_vec3(u + 3);
    const HalfTurn<Real> turn(spin, half, false);
    const Quat<Real> middle = start * turn.factor();
    const Mat3<Real> axes = to_mat3(middle);
    const Vec3<Real> air = transpose_times(axes, velocity);
    const FreeRatesAdjoint<Real> early(c, sums, air, spin);
    const Vec3<Real> late_air = air + (early.in_body + transpose_times(axes, gravity)) * Real(half);
    const Vec3<Real> late_spin = spin + early.spin_rate * Real(half);
    const FreeRatesAdjoint<Real> late(c, sums, late_air, late_spin);
    const Vec3<Real> end_spin = spin + late.spin_rate * Real(dt);
    const HalfTurn<Real> last_turn(end_spin, half, true);
    const Quat<Real> stretched = middle * last_turn.factor();

    // Backwards.
    const Real inverse_norm = 1.0 / sqrt(squared_norm(stretched));
    const Quat<Real> to_end = load_quat(LaneValues<Real>(to_q_) + 3);
    const Quat<Real> to_stretched = across(to_end, stretched, inverse_norm);
    const Vec3<Real> to_position = load_vec3(LaneValues<Real>(to_q_));
    Vec3<Real> to_spin = load_vec3(LaneValues<Real>(to_u_) + 3);
    Quat<Real> to_middle = last_turn.pull_back(middle, to_stretched, to_spin);
    Vec3<Real> to_velocity = load_vec3(LaneValues<Real>(to_u_)) + to_position * Real(half);
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
    to_velocity += axes * to_air + to_position * Real(half);
    to_axes = to_axes + outer(velocity, to_air);
    const Quat<Real> by_axes = pull_back_axes(middle, to_axes);
    to_middle = {to_middle.w + by_axes.w, to_middle.x + by_axes.x, to_middle.y + by_axes.y,
                 to_middle.z + by_axes.z};
    const Quat<Real> to_start = turn.pull_back(start, to_middle, to_spin);
    put(to_q_, 3, to_start.w, mask);
    put(to_q_, 4, to_start.x, mask);
    put(to_q_, 5, to_start.y, mask);
    put(to_q_, 6, to_start.z, mask);
    put(to_u_, 0, to_velocity.x, mask);
    put(to_u_, 1, to_velocity.y, mask);
    put(to_u_, 2, to_velocity.z, mask);
    put(to_u_, 3, to_spin.x, mask);
    put(to_u_, 4, to_spin.y, mask);
    put(to_u_, 5, to_spin.z, mask);
    for (int i = 0; i < rotors; ++i) pull_back_rotor(i, to_sums, mask);
  }

 private:
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

  /// Of q / |q|.
  static SKYBODY_INLINE Quat<Real> across(const Quat<Real>& to, const Quat<Real>& q,
                                          const Real& inverse_norm) {
    const Real along =
        (to.w * q.w + to.x * q.x + to.y * q.y + to.z * q.z) * (inverse_norm * inverse_norm);
    return {(to.w - q.w * along) * inverse_norm, (to.x - q.x * along) * inverse_norm,
            (to.y - q.y * along) * inverse_norm, (to.z - q.z * along) * inverse_norm};
  }
  static SKYBODY_INLINE Mat3<Real> outer(const Vec3<Real>& a, const Vec3<Real>& b) {
    return {{a.x * b.x, a.x * b.y, a.x * b.z, a.y * b.x, a.y * b.y, a.y * b.z, a.z * b.x, a.z * b.y,
             a.z * b.z}};
  }
  static SKYBODY_INLINE void put(double* block, int k, const Real& x, const MaskOf<Real>& mask) {
    store_lanes(block + k * kLaneStride<Real>, x, mask);
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
