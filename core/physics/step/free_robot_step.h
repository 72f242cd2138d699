// One step of a robot of one free body, from coordinates to coordinates, without stored
// intermediate values. On double and packs. The laws are those of every robot (rotor_force.h,
// force_terms.h, force_accumulators.h, integration_rules.h), combined here in the axes of the body.
#pragma once

#include "core/physics/bodies/torque_free.h"
#include "core/physics/forces/force_terms.h"
#include "core/physics/step/free_robots.h"
#include "core/physics/step/held_input_set.h"
#include "core/physics/step/held_rotor.h"
#include "core/physics/step/integration_rules.h"
#include "core/physics/world/lane_values.h"

namespace skybody {

/// Coordinates of a free body, as in its q and u and, in this order, in its BodyState; or their
/// rates.
template <class Real>
struct FreeMotion {
  Vec3<Real> position;
  Quat<Real> rotation;  ///< W from B, unit
  Vec3<Real> velocity;  ///< of the origin, W axes
  Vec3<Real> spin;      ///< body axes

  /// start + time rate, element by element.
  SKYBODY_INLINE void set(const FreeMotion& start, const FreeMotion& rate, double time) {
    const Real t(time);
    const Quat<Real>&q = start.rotation, &r = rate.rotation;
    position = start.position + rate.position * t;
    rotation = {q.w + r.w * t, q.x + r.x * t, q.y + r.y * t, q.z + r.z * t};
    velocity = start.velocity + rate.velocity * t;
    spin = start.spin + rate.spin * t;
  }
  SKYBODY_INLINE void add(const FreeMotion& rate) {
    position += rate.position;
    add(rate.rotation);
    velocity += rate.velocity;
    spin += rate.spin;
  }
  /// @param rate  has velocity and spin
  template <class Rate>
  SKYBODY_INLINE void change_velocity(const Rate& rate, double time) {
    velocity += rate.velocity * Real(time);
    spin += rate.spin * Real(time);
  }
  SKYBODY_INLINE void change_position(double time) {
    position += velocity * Real(time);
    add(quaternion_change(rotation, spin, time));
  }
  SKYBODY_INLINE void drift(double time) {
    position += velocity * Real(time);
    rotation = turned(rotation, spin, time);
  }
  /// The same except for the quaternion's norm.
  SKYBODY_INLINE void drift_and_stretch(double time) {
    position += velocity * Real(time);
    rotation = integrate_rotation_unnormalized(rotation, spin, time);
  }

 private:
  SKYBODY_INLINE void add(const Quat<Real>& q) {
    rotation = {rotation.w + q.w, rotation.x + q.x, rotation.y + q.y, rotation.z + q.z};
  }
};

/// Inputs of the step.
/// @tparam Values   access to parameters and values derived from them: LaneValues, SharedValues
template <class Real, class Values>
struct FreeStepInputs {
  LaneValues<Real> rotor_speed, rotor_command, wrench;
  HeldLanes<Real> held;
  Values params;
  Values lags, factors, bodies;  ///< of the whole world
};

/// Properties of a robot that are known when its step is compiled.
enum class FreeKind {
  kAny,
  kQuadrotor,      ///< it has four level rotors
  kPlainQuadrotor  ///< FreeRobot::is_plain_quadrotor, with nominal parameters
};

/// Index in a block of the world where the robot's values begin: 0 for the only robot.
template <FreeKind kKind>
constexpr int first_place(int place) {
  return kKind == FreeKind::kPlainQuadrotor ? 0 : place;
}

/// Lanes that are fast by fast_spin_square() are rare and have their own kernel, which handles the
/// lanes that other kernels leave. One kernel for both would cost other lanes 6 % of a step.
enum class SpinKind {
  kSlow,  ///< fast lanes fail
  kAny
};

template <class Real, class Values, FreeKind kKind, HeldInputSet kHeld, SpinKind kSpin>
class FreeRobotStep {
 public:
  using Inputs = FreeStepInputs<Real, Values>;

  SKYBODY_INLINE FreeRobotStep(const FreeRobots& world, const FreeRobot& robot, const Inputs& in)
      : world_(world),
        robot_(robot),
        in_(in),
        lags_(in.lags + kLagSize * first_rotor()),
        factors_(in.factors + kRotorFactorCount * first_rotor()),
        constants_(in.bodies + kBodyConstantCount * first_place<kKind>(robot.body)) {}

  /// Advances the robot by dt.
  /// @param load       load() gives the motion at the start of the step
  /// @param motion     at its end, written
  /// @param end_speed  per rotor of the robot: speed at the end of the step [rad/s]
  /// @returns the lanes that succeeded: all values are finite, and the sum of their magnitudes is
  ///          below kLargestState; with kSlow, the spin was also not fast at the start
  template <IntegratorChoice kIntegrator, class Load>
  SKYBODY_INLINE MaskOf<Real> advance(const Load& load, FreeMotion<Real>& motion,
                                      Real* end_speed) const {
    if constexpr (kIntegrator == IntegratorChoice::kRk4) {
      return advance_by_rk4(load, motion, end_speed);
    } else {
      const MaskOf<Real> sound =
          advance_split<kIntegrator>(drifts(load()), load, motion, end_speed);
      if constexpr (kSpin == SpinKind::kAny) return sound;
      return logical_and(sound, logical_not(is_fast(load())));
    }
  }

 private:
  /// Parameters are nominal: the properties in FreeRobot hold.
  static constexpr bool kIsNominal = std::is_same_v<Values, SharedValues<Real>>;
  static constexpr bool kHasFour = kKind != FreeKind::kAny;
  static constexpr bool kIsPlain = kKind == FreeKind::kPlainQuadrotor;

  // Values read again after forget() need not be kept in registers, which are scarce.
  static SKYBODY_INLINE void forget() { asm volatile("" ::: "memory"); }

  /// A rule that changes only velocities by rates.
  /// @param fast  FastSpin, or NoFastSpin
  template <IntegratorChoice kIntegrator, class Fast, class Load>
  SKYBODY_INLINE MaskOf<Real> advance_split(const Fast& fast, const Load& load,
                                            FreeMotion<Real>& motion, Real* end_speed) const {
    if constexpr (kIntegrator == IntegratorChoice::kMidpoint) {
      return advance_by_midpoint(fast, load, motion, end_speed);
    } else {
      return advance_by_euler(fast, load, motion, end_speed);
    }
  }

  /// kMidpointRule (integration_rules.h). The predictor's velocity stays in body axes, since both
  /// evaluations use the axes of half the step.
  template <class Fast, class Load>
  SKYBODY_INLINE MaskOf<Real> advance_by_midpoint(const Fast& fast, const Load& load,
                                                  FreeMotion<Real>& motion, Real* end_speed) const {
    const auto run = [&](int i) SKYBODY_INLINE_LAMBDA {
      const auto rotor = rotor_step(i);
      end_speed[i] = rotor.at(kStepEnd).speed;
      return rotor.mean(end_speed[i]);
    };
    CoplanarRotors<Real> level;
    if (is_level()) level = quick_level_rotors(run);
    motion = load();
    drift(fast, 0.5 * dt(), motion,
          [&](FreeMotion<Real>& m) SKYBODY_INLINE_LAMBDA { m.drift(0.5 * dt()); });
    BodyKinematics<Real> body = kinematics(motion);
    Vec3<Real> air = velocity_in_air(body);
    FreeRates<Real> first = rates(body, air, level, run, world_.rate);
    subtract_torque_free_rates(fast, body, first);
    const Real half(kMidpointRule.reach[1] * dt());
    air += first.velocity_in_body(body.axes, is_upright()) * half;
    body.spin += first.spin * half;
    forget();  // measured: 3 % of the step
    FreeRates<Real> second = rates(body, air, level, run, world_.rate);
    subtract_torque_free_rates(fast, body, second);
    motion.change_velocity(second.acceleration(body.axes), dt());
    drift(fast, 0.5 * dt(), motion,
          [&](FreeMotion<Real>& m) SKYBODY_INLINE_LAMBDA { m.drift_and_stretch(0.5 * dt()); });
    return is_sound(motion);
  }

  template <class Fast, class Load>
  SKYBODY_INLINE MaskOf<Real> advance_by_euler(const Fast& fast, const Load& load,
                                               FreeMotion<Real>& motion, Real* end_speed) const {
    const auto run = [&](int i) SKYBODY_INLINE_LAMBDA {
      const auto rotor = rotor_step(i);
      end_speed[i] = rotor.at(kStepEnd).speed;
      return rotor.in_middle(end_speed[i]);
    };
    CoplanarRotors<Real> level;
    if (is_level()) level = level_rotors(run);
    forget();  // the sums need no motion
    const BodyKinematics<Real> body = kinematics(load());
    FreeRates<Real> first = rates(body, velocity_in_air(body), level, run, world_.rate);
    subtract_torque_free_rates(fast, body, first);
    forget();
    motion = load();
    motion.change_velocity(first.acceleration(body.axes), dt());
    drift(fast, dt(), motion,
          [&](FreeMotion<Real>& m) SKYBODY_INLINE_LAMBDA { m.change_position(dt()); });
    return is_sound(motion);
  }

  template <class Load>
  SKYBODY_INLINE MaskOf<Real> advance_by_rk4(const Load& load, FreeMotion<Real>& motion,
                                             Real* end_speed) const {
    const auto rotor_at = [&](int i, StageTime time)
                              SKYBODY_INLINE_LAMBDA { return rotor_step(i).at(time); };
    CoplanarRotors<Real> level[kStageTimeCount];
    for (const StageTime time : {kStepStart, kStepMiddle, kStepEnd}) {
      const auto run = [&](int i) SKYBODY_INLINE_LAMBDA { return rotor_at(i, time); };
      if (is_level()) level[time] = level_rotors(run);
    }
    for (int i = 0; i < rotor_count(); ++i) end_speed[i] = rotor_at(i, kStepEnd).speed;
    const auto rates = [&](const FreeMotion<Real>& at, StageTime time,
                           FreeMotion<Real>& rate) SKYBODY_INLINE_LAMBDA {
      FreeMotion<Real> unit = at;
      if (time != kStepStart) renormalize(unit);
      const auto run = [&](int i) SKYBODY_INLINE_LAMBDA { return rotor_at(i, time); };
      const FreeAcceleration<Real> a = acceleration(kinematics(unit), level[time], run, 1.0);
      rate = {at.velocity, quaternion_change(at.rotation, at.spin, 1.0), a.velocity, a.spin};
    };
    motion = load();
    StageRates<FreeMotion<Real>> work;
    step_by_stages(kRungeKutta4Rule, dt(), rates, motion, work);
    return is_sound(motion);
  }

  SKYBODY_INLINE MaskOf<Real> is_fast(const FreeMotion<Real>& start) const {
    return squared_norm(start.spin) > world_.fast_square;
  }
  /// Lanes that are fast.
  struct FastSpin {
    MaskOf<Real> mask;
  };
  /// No fast lanes.
  struct NoFastSpin {};
  SKYBODY_INLINE auto drifts(const FreeMotion<Real>& start) const {
    if constexpr (kSpin == SpinKind::kAny) {
      return FastSpin{is_fast(start)};
    } else {
      return NoFastSpin();
    }
  }

  /// Moves the robot for a time without forces.
  /// @param slowly  slowly(motion) moves it in lanes that are not fast
  template <class Slowly>
  SKYBODY_INLINE void drift(const NoFastSpin&, double, FreeMotion<Real>& motion,
                            const Slowly& slowly) const {
    slowly(motion);
  }
  template <class Slowly>
  SKYBODY_INLINE void drift(const FastSpin& fast, double time, FreeMotion<Real>& motion,
                            const Slowly& slowly) const {
    FreeMotion<Real> slow = motion;
    slowly(slow);
    const SymMat3<Real> inertia = load_sym_mat3(constants_ + kBodyInertia);
    const Vec3<Real> com = load_vec3(constants_ + kBodyCom);
    move_freely(TorqueFreeCall<Real>{inertia, com, Real(time), fast.mask, motion.position,
                                     motion.rotation, motion.velocity, motion.spin});
    motion.position = select(fast.mask, motion.position, slow.position);
    motion.rotation = select(fast.mask, motion.rotation, slow.rotation);
  }

  /// Subtracts the effect of the body's own spin from the rates of fast lanes; drift() applies it.
  SKYBODY_INLINE void subtract_torque_free_rates(const NoFastSpin&, const BodyKinematics<Real>&,
                                                 FreeRates<Real>&) const {}
  SKYBODY_INLINE void subtract_torque_free_rates(const FastSpin& fast,
                                                 const BodyKinematics<Real>& body,
                                                 FreeRates<Real>& rates) const {
    const SpatialForce<Real> none = SpatialForce<Real>::zero();
    const FreeRates<Real> own =
        FreeBodyForceAccumulator<Real, Values>(body, constants_, known_shape(), none.force, none)
            .rates();
    rates.in_body = select(fast.mask, rates.in_body - own.in_body, rates.in_body);
    rates.spin = select(fast.mask, rates.spin - own.spin, rates.spin);
  }

  double dt() const { return world_.world.scenario.stepping.dt; }
  Values world_constants() const { return in_.params + world_.world.layout.world_params; }
  bool is_level() const { return kHasFour || robot_.rotors.is_level; }
  SKYBODY_INLINE bool is_held(int input) const {
    return may_hold(kHeld, input) && in_.held.has(input);
  }
  /// Forces other than rotors and drag accelerate the robot along z of W only.
  bool is_upright() const { return kIsPlain && !is_held(SKYBODY_HELD_WRENCH); }
  int first_rotor() const { return first_place<kKind>(robot_.rotors.first); }
  int rotor_count() const { return kHasFour ? 4 : robot_.rotors.count; }

  /// @param i  index among the robot's rotors
  SKYBODY_INLINE auto rotor_step(int i) const {
    const int rotor = first_rotor() + i;
    if constexpr (may_hold(kHeld, SKYBODY_HELD_ROTOR_RATE)) {
      return HeldRotorStep<Real>(
          load_lag<Real>(lags_ + kLagSize * i), in_.rotor_speed[rotor], in_.rotor_command[rotor],
          factors_[kRotorFactorCount * i + kSpeedLimit], held_rotor(in_.held, rotor), dt());
    } else {  // in one expression: copies cost 5 % of a step
      return RotorStep<Real>(load_lag<Real>(lags_ + kLagSize * i), in_.rotor_speed[rotor],
                             command(rotor), factors_[kRotorFactorCount * i + kSpeedLimit]);
    }
  }

  /// Command of a rotor of the world, clamped to held limits.
  SKYBODY_INLINE Real command(int rotor) const {
    if (!is_held(SKYBODY_HELD_ROTOR_LIMIT)) return in_.rotor_command[rotor];
    const HeldLimits<Real> limits = held_limits(in_.held, rotor);
    return clamp(in_.rotor_command[rotor], limits.lower, limits.upper);
  }

  /// @param run  run(i): the motion of rotor i of the robot
  template <class Run>
  SKYBODY_INLINE CoplanarRotors<Real> level_rotors(const Run& run) const {
    const auto alone = [&](int i) SKYBODY_INLINE_LAMBDA {
      if (!is_held(SKYBODY_HELD_ROTOR_GAIN)) {
        return CoplanarRotors<Real>(factors_ + kRotorFactorCount * i, run(i));
      }
      const RotorMount& place = world_.rotors[static_cast<std::size_t>(first_rotor() + i)];
      const auto gains = in_.held[SKYBODY_HELD_ROTOR_GAIN] + kGainedConstants * (first_rotor() + i);
      Real factors[kRotorFactorCount];
      make_rotor_factors(ScaledRotorConstants(in_.params + place.params, gains), place, factors);
      return CoplanarRotors<Real>(factors, run(i));
    };
    CoplanarRotors<Real> rotors = alone(0);
    const int count = rotor_count();
#pragma GCC unroll 4
    for (int i = 1; i < count; ++i) rotors += alone(i);
    return rotors;
  }

  /// The same, with fewer operations in lanes whose rotors are alike and in rows.
  template <class Run>
  SKYBODY_INLINE CoplanarRotors<Real> quick_level_rotors(const Run& run) const {
    const auto by_rows = [&]() SKYBODY_INLINE_LAMBDA {
      const RotorMotion<Real> rotors[4] = {run(0), run(1), run(2), run(3)};
      return CoplanarRotors<Real>(factors_, rotors);
    };
    if (is_held(SKYBODY_HELD_ROTOR_GAIN)) return level_rotors(run);
    if (kIsPlain) return by_rows();
    if (!robot_.are_rotors_in_rows) return level_rotors(run);
    if (kIsNominal) return robot_.are_rotors_alike ? by_rows() : level_rotors(run);
    const auto alike = are_alike(factors_);
    if (all(alike)) return by_rows();
    if (none(alike)) return level_rotors(run);
    return select(alike, by_rows(), level_rotors(run));
  }

  static SKYBODY_INLINE BodyKinematics<Real> kinematics(const FreeMotion<Real>& m) {
    BodyKinematics<Real> body;
    body.position = m.position;
    body.rotation = m.rotation;
    body.axes = to_mat3(body.rotation);
    body.velocity = m.velocity;
    body.spin = m.spin;
    return body;
  }

  SKYBODY_INLINE Vec3<Real> velocity_in_air(const BodyKinematics<Real>& body) const {
    return air_velocity(is_held(SKYBODY_HELD_WIND) ? &in_.held : nullptr, robot_.body, body);
  }

  template <class Run>
  SKYBODY_INLINE FreeAcceleration<Real> acceleration(const BodyKinematics<Real>& body,
                                                     const CoplanarRotors<Real>& level,
                                                     const Run& run, double unit) const {
    return rates(body, velocity_in_air(body), level, run, unit).acceleration(body.axes);
  }

  /// @param velocity  of the origin through the air, body axes
  /// @param level  the rotors, if level; otherwise run(i) gives the motion of each
  /// @param unit   of the rotors' accelerations [rad/s^2]
  template <class Run>
  SKYBODY_INLINE FreeRates<Real> rates(const BodyKinematics<Real>& body, const Vec3<Real>& velocity,
                                       const CoplanarRotors<Real>& level, const Run& run,
                                       double unit) const {
    const RotorGroup& group = robot_.rotors;
    SpatialForce<Real> rotors = SpatialForce<Real>::zero();
    const auto run_of_world = [&](int i) SKYBODY_INLINE_LAMBDA { return run(i - group.first); };
    if (is_level()) {
      rotors = level.force(factors_[kHeightFactor], unit, velocity, body.spin);
      if (is_held(SKYBODY_HELD_ROTOR_FLOW)) {
        add_flow_forces<Real>(group, world_.rotors.data(), in_.params,
                              in_.held[SKYBODY_HELD_ROTOR_FLOW], run_of_world, velocity, body.spin,
                              rotors);
      }
    }
    if (!is_level() || has_uneven_hubs()) {
      rotors = select(has_even_hubs(), rotors,
                      uneven_rotor_forces(run_of_world, unit, velocity, body.spin));
    }
    FreeBodyForceAccumulator<Real, Values> load(body, constants_, known_shape(),
                                                load_vec3(world_constants() + kGravity), rotors);
    add_outer_forces(body, velocity, load);
    return load.rates();
  }

  /// Force of rotors that are not level, or whose hubs are randomized to different heights.
  /// @param run  run(i): the motion of rotor i of the world
  template <class Run>
  SKYBODY_INLINE SpatialForce<Real> uneven_rotor_forces(const Run& run, double unit,
                                                        const Vec3<Real>& velocity,
                                                        const Vec3<Real>& spin) const {
    const RotorMount* places = world_.rotors.data();
    if constexpr (kHeld == HeldInputSet::kAnything) {
      return held_rotor_forces<Real>(robot_.rotors, places, in_.params, &in_.held, run, unit,
                                     velocity, spin);
    } else {
      const auto constants = [&](int i)
                                 SKYBODY_INLINE_LAMBDA { return in_.params + places[i].params; };
      return sum_rotors<Real>(robot_.rotors, places, constants, run, unit, velocity, spin);
    }
  }

  /// Lanes in which the hubs of level rotors, which may be randomized, are at one height.
  SKYBODY_INLINE MaskOf<Real> has_even_hubs() const {
    if (!is_level()) return MaskOf<Real>(false);
    return are_level<Real>(rotor_count(), [&](int i) SKYBODY_INLINE_LAMBDA {
      return Real(factors_[kRotorFactorCount * i + kHeightFactor]);
    });
  }
  SKYBODY_INLINE bool has_uneven_hubs() const { return !kIsNominal && !all(has_even_hubs()); }

  SKYBODY_INLINE InertiaStructure known_shape() const {
    if (kIsPlain) return {true, true};
    return kIsNominal ? robot_.shape : InertiaStructure();
  }

  /// Forces that only some robots have.
  /// @param velocity  as for rates()
  template <class Load>
  SKYBODY_INLINE void add_outer_forces(const BodyKinematics<Real>& body, const Vec3<Real>& velocity,
                                       Load& load) const {
    if (!kIsNominal || robot_.is_disturbed) {
      add_disturbance<Real>(in_.params + robot_.constants, load);
    }
    if (is_held(SKYBODY_HELD_WRENCH)) add_held_wrench(in_.held, robot_.body, load);
    if (is_held(SKYBODY_HELD_BODY_DRAG)) {
      const int drag = 6 * first_place<kKind>(robot_.body);
      add_body_drag<Real>(in_.held[SKYBODY_HELD_BODY_DRAG] + drag, velocity, body, load);
    }
    for (const int site : robot_.sites) {
      add_wrench<Real>(world_.world.sites[static_cast<std::size_t>(site)], in_.wrench + 6 * site,
                       load);
    }
  }

  /// Normalises the quaternion. @returns the square of its norm before
  static SKYBODY_INLINE Real renormalize(FreeMotion<Real>& motion) {
    const Real squared = squared_norm(motion.rotation);
    motion.rotation = renormalized(motion.rotation, squared);
    return squared;
  }

  /// Normalises the quaternion. @returns the lanes in which all values are finite and the sum of
  /// their magnitudes is bounded. Rotors keep within their limits, unless they cause a force that
  /// is not finite.
  static SKYBODY_INLINE MaskOf<Real> is_sound(FreeMotion<Real>& motion) {
    const Real squared = renormalize(motion);
    const Vec3<Real>& w = motion.spin;
    const Real size = size_of(motion) + ((abs(w.x) + abs(w.y)) + abs(w.z));
    return logical_and(logical_and(squared > 0.0, squared < kInfinity), size < kLargestState);
  }

  /// Sum of the magnitudes of position and velocity.
  static SKYBODY_INLINE Real size_of(const FreeMotion<Real>& m) {
    const auto size = [](const Vec3<Real>& v) { return (abs(v.x) + abs(v.y)) + abs(v.z); };
    return size(m.position) + size(m.velocity);
  }

  const FreeRobots& world_;
  const FreeRobot& robot_;
  const Inputs& in_;
  Values lags_, factors_, constants_;  ///< of the robot
};

}  // namespace skybody
