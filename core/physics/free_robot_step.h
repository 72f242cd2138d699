// One step of a robot that is one free body, from its coordinates to its coordinates: Newton and
// Euler about the centre of mass, in the axes of the body. On double and packs.
#pragma once

#include "core/physics/body_constants.h"
#include "core/physics/free_robots.h"
#include "core/physics/lane_values.h"
#include "core/physics/step_rules.h"
#include "core/physics/stepper.h"

namespace skybody {

/// Coordinates of a free body, as its q and u have them and, in this order, its BodyState.
template <class Real>
struct FreeMotion {
  Vec3<Real> position;
  Quat<Real> rotation;  ///< W from B, unit
  Vec3<Real> velocity;  ///< of the origin, W axes
  Vec3<Real> spin;      ///< body axes

  /// Number by number: with rates of these times a time.
  SKYBODY_INLINE FreeMotion& operator+=(const FreeMotion& o) {
    position += o.position;
    rotation = {rotation.w + o.rotation.w, rotation.x + o.rotation.x, rotation.y + o.rotation.y,
                rotation.z + o.rotation.z};
    velocity += o.velocity;
    spin += o.spin;
    return *this;
  }
  friend SKYBODY_INLINE FreeMotion operator*(const FreeMotion& m, const Real& factor) {
    const Quat<Real>& q = m.rotation;
    return {m.position * factor,
            {q.w * factor, q.x * factor, q.y * factor, q.z * factor},
            m.velocity * factor,
            m.spin * factor};
  }
};

/// What such a step holds.
/// @tparam Values   how values of WorldState are read: a pointer, or a view (lane_values.h)
/// @tparam Params, Derived  likewise parameters and what derives from them (pack_world.h)
template <class Values, class Params, class Derived>
struct FreeStepInputs {
  Values rotor_speed, rotor_command, wrench;
  Params params;
  Derived lags, factors, bodies;  ///< of the whole world
};

/// @tparam Real         double or a pack
/// @tparam kLevelRotors 0: any rotors; else the robot has so many, all of them level
template <class Real, class Values, class Params, class Derived, int kLevelRotors>
class FreeRobotStep {
 public:
  using Inputs = FreeStepInputs<Values, Params, Derived>;

  SKYBODY_INLINE FreeRobotStep(const FreeRobots& world, const FreeRobot& robot, const Inputs& in)
      : world_(world),
        robot_(robot),
        in_(in),
        lags_(in.lags + kLagSize * robot.rotors.first),
        factors_(in.factors + kRotorFactorCount * robot.rotors.first),
        constants_(in.bodies + kBodyConstantCount * robot.body) {}

  /// Moves the robot on by dt.
  /// @param load       load() gives the motion at the start of the step
  /// @param motion     at its end, written
  /// @param end_speed  per rotor of the robot: speed at the end of the step [rad/s]
  /// @returns where all of it is finite and below kLargestState: the rates of turn, and the
  ///          magnitudes of all else added up (rk4: of all)
  template <IntegratorChoice kIntegrator, class Load>
  SKYBODY_INLINE MaskOf<Real> advance(const Load& load, FreeMotion<Real>& motion,
                                      Real* end_speed) const {
    if constexpr (kIntegrator == IntegratorChoice::kRk4) {
      return runge_kutta_4(load(), motion, end_speed);
    } else {
      return semi_implicit_euler(load, motion, end_speed);
    }
  }

 private:
  // What is read again after forget() need not be kept in registers, of which there are too few.
  template <class Load>
  SKYBODY_INLINE MaskOf<Real> semi_implicit_euler(const Load& load, FreeMotion<Real>& motion,
                                                  Real* end_speed) const {
    Real speeds(0.0);
    const Accelerations a = accelerations(load, end_speed, speeds);
    forget();
    motion = load();
    const Real squared = integrate(a, motion);
    const auto turns = logical_and(squared > 0.0, squared < world_.largest_square);
    return logical_and(turns, size_of(motion) + speeds < kLargestState);
  }

  /// Its stages as step_rules.h has them; rotors follow their closed form at the stages' times.
  SKYBODY_INLINE MaskOf<Real> runge_kutta_4(const FreeMotion<Real>& start, FreeMotion<Real>& motion,
                                            Real* end_speed) const {
    LevelRotors<Real> rotors[kStageTimeCount];
    Real speeds(0.0);
    const bool is_level = kLevelRotors > 0 || robot_.rotors.is_level;
    for (const StageTime time : {kStepStart, kStepMiddle, kStepEnd}) {
      if (is_level) rotors[time] = level_rotors_at(time);
    }
    const int count = kLevelRotors > 0 ? kLevelRotors : robot_.rotors.count;
    for (int i = 0; i < count; ++i) {
      end_speed[i] = rotor_step(i).at(kStepEnd).speed;
      speeds += end_speed[i];
    }
    // Of the four rates the first and the last are added up, and those between.
    FreeMotion<Real> outer = rates(start, start.rotation, rotors[kStepStart], kStepStart);
    FreeMotion<Real> rate =
        stage_rates(moved(start, outer, 0.5 * dt()), rotors[kStepMiddle], kStepMiddle);
    FreeMotion<Real> inner = rate;
    rate = stage_rates(moved(start, rate, 0.5 * dt()), rotors[kStepMiddle], kStepMiddle);
    inner += rate;
    outer += stage_rates(moved(start, rate, dt()), rotors[kStepEnd], kStepEnd);
    outer += inner * Real(2.0);
    motion = start;
    motion += outer * Real(dt() / 6.0);
    const Real squared = squared_norm(motion.rotation);
    motion.rotation = renormalized(motion.rotation, squared);
    const Vec3<Real>& w = motion.spin;
    const Real size = (size_of(motion) + speeds) + ((abs(w.x) + abs(w.y)) + abs(w.z));
    return logical_and(logical_and(squared > 0.0, squared < kInfinity), size < kLargestState);
  }

  /// Parameters are the nominal ones: what FreeRobot knows of them holds.
  static constexpr bool kIsNominal = std::is_same_v<Params, SharedValues<Real>>;

  /// Of the body's origin (W) and of the body (its axes).
  struct Accelerations {
    Vec3<Real> linear, angular;
  };

  double dt() const { return world_.world.scenario.stepping.dt; }

  static SKYBODY_INLINE BodyKinematics<Real> kinematics(const FreeMotion<Real>& m) {
    BodyKinematics<Real> body;
    body.position = m.position;
    body.rotation = m.rotation;
    body.axes = to_mat3(body.rotation);
    body.velocity = m.velocity;
    body.spin = m.spin;
    return body;
  }

  static SKYBODY_INLINE void forget() { asm volatile("" ::: "memory"); }

  /// @param speeds  sum of the rotors' speeds at the end, written
  template <class Load>
  SKYBODY_INLINE Accelerations accelerations(const Load& load, Real* end_speed,
                                             Real& speeds) const {
    const RotorGroup& group = robot_.rotors;
    if (kLevelRotors > 0 || group.is_level) {
      const LevelRotors<Real> rotors = run_level_rotors(end_speed, speeds);
      forget();  // the sums need no motion
      const BodyKinematics<Real> body = kinematics(load());
      const double height = world_.rotors[static_cast<std::size_t>(group.first)].position.z;
      return accelerations(body,
                           rotors.force(height, world_.rate, velocity_in_body(body), body.spin));
    }
    speeds = Real(0.0);
    const auto run = [&](int i) SKYBODY_INLINE_LAMBDA {
      const RotorStep<Real> step = rotor_step(i - group.first);
      const Real end = step.at(kStepEnd).speed;
      end_speed[i - group.first] = end;
      speeds += end;
      return step.mean(end, world_.rate);
    };
    const BodyKinematics<Real> body = kinematics(load());
    return accelerations(body, sum_rotors<Real>(group, world_.rotors.data(), in_.params, run,
                                                velocity_in_body(body), body.spin));
  }

  SKYBODY_INLINE LevelRotors<Real> level_rotors_at(StageTime time) const {
    const auto run = [&](int i) SKYBODY_INLINE_LAMBDA {
      const RotorMotion<Real> rotor = rotor_step(i).at(time);
      return LevelRotors<Real>(factors_ + kRotorFactorCount * i, rotor.speed, rotor.acceleration);
    };
    LevelRotors<Real> rotors = run(0);
    const int count = kLevelRotors > 0 ? kLevelRotors : robot_.rotors.count;
#pragma GCC unroll 4
    for (int i = 1; i < count; ++i) rotors += run(i);
    return rotors;
  }

  /// A stage's point.
  static SKYBODY_INLINE FreeMotion<Real> moved(const FreeMotion<Real>& start,
                                               const FreeMotion<Real>& rate, double time) {
    FreeMotion<Real> at = start;
    at += rate * Real(time);
    return at;
  }

  SKYBODY_INLINE FreeMotion<Real> stage_rates(const FreeMotion<Real>& at,
                                              const LevelRotors<Real>& level,
                                              StageTime time) const {
    return rates(at, renormalized(at.rotation, squared_norm(at.rotation)), level, time);
  }

  /// What the coordinates change by in a second.
  /// @param at     its quaternion of any norm near 1
  /// @param unit   the same quaternion, of norm 1
  /// @param level  the rotors at that time, where they are level
  SKYBODY_INLINE FreeMotion<Real> rates(const FreeMotion<Real>& at, const Quat<Real>& unit,
                                        const LevelRotors<Real>& level, StageTime time) const {
    const BodyKinematics<Real> body = kinematics({at.position, unit, at.velocity, at.spin});
    const Vec3<Real> velocity = velocity_in_body(body);
    const RotorGroup& group = robot_.rotors;
    SpatialForce<Real> force = SpatialForce<Real>::zero();
    if (kLevelRotors > 0 || group.is_level) {
      const double height = world_.rotors[static_cast<std::size_t>(group.first)].position.z;
      force = level.force(height, 1.0, velocity, body.spin);
    } else {
      const auto run = [&](int i)
                           SKYBODY_INLINE_LAMBDA { return rotor_step(i - group.first).at(time); };
      force = sum_rotors<Real>(group, world_.rotors.data(), in_.params, run, velocity, body.spin);
    }
    const Accelerations a = accelerations(body, force);
    return {at.velocity, quaternion_rate(at.rotation, at.spin), a.linear, a.angular};
  }

  /// @param i  of the robot's rotors
  SKYBODY_INLINE RotorStep<Real> rotor_step(int i) const {
    const int rotor = robot_.rotors.first + i;
    return {load_lag<Real>(lags_ + kLagSize * i), in_.rotor_speed[rotor], in_.rotor_command[rotor],
            factors_[kRotorFactorCount * i + kSpeedLimit]};
  }

  static SKYBODY_INLINE Vec3<Real> velocity_in_body(const BodyKinematics<Real>& body) {
    return transpose_times(body.axes, body.velocity);
  }

  /// Accelerations in rad/s a step: force() is told the rate.
  SKYBODY_INLINE LevelRotors<Real> run_level_rotors(Real* end_speed, Real& speeds) const {
    const auto run = [&](int i) SKYBODY_INLINE_LAMBDA {
      const RotorStep<Real> step = rotor_step(i);
      end_speed[i] = step.at(kStepEnd).speed;
      return LevelRotors<Real>(factors_ + kRotorFactorCount * i, step.at(kStepMiddle).speed,
                               end_speed[i] - step.speed);
    };
    LevelRotors<Real> rotors = run(0);
    speeds = end_speed[0];
    const int count = kLevelRotors > 0 ? kLevelRotors : robot_.rotors.count;
#pragma GCC unroll 4
    for (int i = 1; i < count; ++i) {
      rotors += run(i);
      speeds += end_speed[i];
    }
    return rotors;
  }

  /// Gravity acts at the centre of mass, so that it turns nothing.
  /// @param rotors  about the origin, body axes
  SKYBODY_INLINE Accelerations accelerations(const BodyKinematics<Real>& body,
                                             const SpatialForce<Real>& rotors) const {
    const Real inverse_mass = constants_[kBodyInverseMass];
    const Vec3<Real> com = load_vec3(constants_ + kBodyCom);
    Vec3<Real> linear = to_real<Real>(world_.world.scenario.gravity);
    Vec3<Real> moment = rotors.moment;
    const Vec3<Real>& w = body.spin;
    const Vec3<Real>& f = rotors.force;
    // About the centre of mass, which most robots have on their z axis.
    const Vec3<Real> on_axis{moment.x + com.z * f.y, moment.y - com.z * f.x, moment.z};
    moment = by_com(com, on_axis, [&]() SKYBODY_INLINE_LAMBDA { return moment - cross(com, f); });
    add_outer_forces(body, com, inverse_mass, linear, moment);
    const Vec3<Real> momentum = turn(kBodyInertia, w);
    const Vec3<Real> angular = turn(kBodyInverseInertia, moment - cross(w, momentum));
    const Vec3<Real> axial{com.z * (angular.y + w.x * w.z), com.z * (w.y * w.z - angular.x),
                           -(com.z * (w.x * w.x + w.y * w.y))};
    const Vec3<Real> com_from_origin = by_com(com, axial, [&]() SKYBODY_INLINE_LAMBDA {
      return cross(angular, com) + cross(w, cross(w, com));
    });
    linear += body.axes * (f * inverse_mass - com_from_origin);
    return {linear, angular};
  }

  /// `on_axis` where the centre of mass lies on the body's z axis, what `general` gives elsewhere.
  template <class General>
  SKYBODY_INLINE Vec3<Real> by_com(const Vec3<Real>& com, const Vec3<Real>& on_axis,
                                   const General& general) const {
    if (kIsNominal && robot_.is_axial) return on_axis;
    const auto is_off = logical_or(com.x != 0.0, com.y != 0.0);
    if (none(is_off)) return on_axis;
    return select(is_off, general(), on_axis);
  }

  /// A symmetric matrix of the constants times v. Products of inertia are rarely other than zero.
  SKYBODY_INLINE Vec3<Real> turn(int matrix, const Vec3<Real>& v) const {
    const SymMat3<Real> m = load_sym_mat3(constants_ + matrix);
    const Vec3<Real> diagonal{m.xx * v.x, m.yy * v.y, m.zz * v.z};
    if (kIsNominal && !robot_.has_products) return diagonal;
    const auto has_products = is_not_zero(Vec3<Real>{m.xy, m.xz, m.yz});
    if (none(has_products)) return diagonal;
    return select(has_products, m * v, diagonal);
  }

  /// Forces that only some robots, lanes or moments have: lanes without are left as if alone.
  /// @param linear  acceleration of the centre of mass (W), added
  /// @param moment  about the centre of mass, body axes, added
  SKYBODY_INLINE void add_outer_forces(const BodyKinematics<Real>& body, const Vec3<Real>& com,
                                       const Real& inverse_mass, Vec3<Real>& linear,
                                       Vec3<Real>& moment) const {
    if (!kIsNominal || robot_.is_disturbed) add_disturbance(inverse_mass, linear, moment);
    for (const int site : robot_.sites) add_wrench(site, body, com, inverse_mass, linear, moment);
    if (robot_.contact.count == 0) return;
    const auto near_ground = body.position.z < robot_.contact.reach;
    if (none(near_ground)) return;
    BodyKinematics<Real> on_ground = body;
    on_ground.angular_velocity = body.axes * body.spin;
    const SpatialForce<Real> ground = ground_forces(robot_.contact, world_.world.spheres.data(),
                                                    world_.world.scenario.contact, on_ground);
    const Vec3<Real> turning = transpose_times(body.axes, ground.moment) -
                               cross(com, transpose_times(body.axes, ground.force));
    linear = select(near_ground, linear + ground.force * inverse_mass, linear);
    moment = select(near_ground, moment + turning, moment);
  }

  /// Paper eq. 1: F_W at the centre of mass, M_B in body axes.
  SKYBODY_INLINE void add_disturbance(const Real& inverse_mass, Vec3<Real>& linear,
                                      Vec3<Real>& moment) const {
    const Params disturbance = in_.params + robot_.disturbance;
    const Vec3<Real> force = load_vec3(disturbance + kDisturbanceForce);
    const Vec3<Real> torque = load_vec3(disturbance + kDisturbanceMoment);
    const auto disturbed = logical_or(is_not_zero(force), is_not_zero(torque));
    if (none(disturbed)) return;
    linear = select(disturbed, linear + force * inverse_mass, linear);
    moment = select(disturbed, moment + torque, moment);
  }

  SKYBODY_INLINE void add_wrench(int index, const BodyKinematics<Real>& body, const Vec3<Real>& com,
                                 const Real& inverse_mass, Vec3<Real>& linear,
                                 Vec3<Real>& moment) const {
    const WrenchSite& site = world_.world.sites[static_cast<std::size_t>(index)];
    Vec3<Real> force = load_vec3(in_.wrench + 6 * index);  // body axes, or W
    Vec3<Real> torque = load_vec3(in_.wrench + (6 * index + 3));
    if (site.world_axes) {
      linear += force * inverse_mass;
      force = transpose_times(body.axes, force);
      torque = transpose_times(body.axes, torque);
    } else {
      linear += body.axes * (force * inverse_mass);
    }
    moment += torque;
    if (!site.at_com) moment += cross(to_real<Real>(site.point) - com, force);
  }

  /// dq/dt = q (0, w) / 2 (paper eq. 1).
  /// @returns the square of the quaternion's norm before it was scaled back to 1: it says how quick
  ///          the turn was
  SKYBODY_INLINE Real integrate(const Accelerations& a, FreeMotion<Real>& m) const {
    m.velocity += a.linear * Real(dt());
    m.spin += a.angular * Real(dt());
    m.position += m.velocity * Real(dt());
    const double half = 0.5 * dt();
    const Vec3<Real>& w = m.spin;
    Quat<Real>& q = m.rotation;
    q = {q.w - half * ((q.x * w.x + q.y * w.y) + q.z * w.z),
         q.x + half * ((q.w * w.x + q.y * w.z) - q.z * w.y),
         q.y + half * ((q.w * w.y + q.z * w.x) - q.x * w.z),
         q.z + half * ((q.w * w.z + q.x * w.y) - q.y * w.x)};
    const Real squared = squared_norm(q);
    q = renormalized(q, squared);
    return squared;
  }

  static SKYBODY_INLINE Quat<Real> quaternion_rate(const Quat<Real>& q, const Vec3<Real>& w) {
    return {
        -0.5 * ((q.x * w.x + q.y * w.y) + q.z * w.z), 0.5 * ((q.w * w.x + q.y * w.z) - q.z * w.y),
        0.5 * ((q.w * w.y + q.z * w.x) - q.x * w.z), 0.5 * ((q.w * w.z + q.x * w.y) - q.y * w.x)};
  }

  /// Magnitudes of position and velocity, added up.
  static SKYBODY_INLINE Real size_of(const FreeMotion<Real>& m) {
    const auto size = [](const Vec3<Real>& v) { return (abs(v.x) + abs(v.y)) + abs(v.z); };
    return size(m.position) + size(m.velocity);
  }

  const FreeRobots& world_;
  const FreeRobot& robot_;
  const Inputs& in_;
  Derived lags_, factors_, constants_;  ///< of the robot
};

}  // namespace skybody
