// Constants of one robot at configure(): masses, limits, texts for messages. All values are
// nominal; randomization is not included.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace skybody::control {

inline Vec3<double> vec3(const double* v) { return {v[0], v[1], v[2]}; }

/// The same constant in every lane.
template <class Real>
SKYBODY_INLINE Vec3<Real> lift(const Vec3<double>& v) {
  return {Real(v.x), Real(v.y), Real(v.z)};
}
template <class Real>
SKYBODY_INLINE SymMat3<Real> lift(const SymMat3<double>& a) {
  return {Real(a.xx), Real(a.yy), Real(a.zz), Real(a.xy), Real(a.xz), Real(a.yz)};
}

/// Each component limited to [-limit, limit].
template <class Real>
SKYBODY_INLINE Vec3<Real> clamp_symmetric(const Vec3<Real>& v, const Vec3<double>& limit) {
  return {clamp(v.x, -limit.x, limit.x), clamp(v.y, -limit.y, limit.y),
          clamp(v.z, -limit.z, limit.z)};
}

/// The unit quaternion along `q`, of any norm; the identity if it vanishes.
template <class Real>
SKYBODY_INLINE Quat<Real> unit_or_identity(const Quat<Real>& q) {
  const Real size = squared_norm(q);
  const auto usable = size > 1e-12;
  const Real scale = 1.0 / sqrt(select(usable, size, Real(1.0)));
  const Quat<Real> unit{q.w * scale, q.x * scale, q.y * scale, q.z * scale};
  return select(usable, unit, Quat<Real>::identity());
}

/// A parameter for which 0 means a default.
inline double or_else(double given, double fallback) { return given > 0.0 ? given : fallback; }
inline Vec3<double> or_else(const Vec3<double>& given, const Vec3<double>& fallback) {
  return {or_else(given.x, fallback.x), or_else(given.y, fallback.y), or_else(given.z, fallback.z)};
}

inline bool all_above_zero(const Vec3<double>& v) { return v.x > 0.0 && v.y > 0.0 && v.z > 0.0; }

/// The parameter `max_force`, by default a vector of the robot's weight [N].
/// @throws std::runtime_error if the default is 0, for want of gravity
inline Vec3<double> force_limit(const RealsParameter& given, const Vec3<double>& fallback) {
  const Vec3<double> limit = or_else(given.vec3(), fallback);
  if (all_above_zero(limit)) return limit;
  refuse("without gravity `max_force` has no default: give three values above 0");
}

inline std::string robot_name(const Setup& setup, int robot) { return setup.robots()[robot].name; }

/// World index of the robot's base body.
inline int base_of(const Setup& setup, int robot) { return setup.robots()[robot].first_body; }

/// Nominal inertia of a body about its centre of mass, body axes [kg m^2].
inline SymMat3<double> inertia_of(const BodyInfo& body) {
  const double* i = body.inertia;
  return {i[0], i[1], i[2], i[3], i[4], i[5]};
}

/// Nominal mass of all bodies of a robot [kg].
inline double total_mass(const Setup& setup, int robot) {
  const RobotInfo& r = setup.robots()[robot];
  double mass = 0.0;
  for (int i = r.first_body; i < r.first_body + r.body_count; ++i) mass += setup.bodies()[i].mass;
  return mass;
}

/// Magnitude of gravity [m/s^2].
inline double gravity_of(const Setup& setup) { return norm(vec3(setup.gravity())); }

/// A rotor's thrust at its maximum speed [N].
inline double full_thrust(const RotorInfo& rotor) {
  const double speed = rotor.constants[SKYBODY_ROTOR_MAX_SPEED];
  return rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT] * speed * speed;
}

/// Whether a rotor pushes upwards while the base is level. An axis within 1e-6 of level counts as
/// level.
inline bool lifts(const RotorInfo& rotor) { return rotor.axis_in_base[2] > 1e-6; }

inline bool is_reversible(const RotorInfo& rotor) { return rotor.min_speed < 0.0; }

/// A rotor's thrust at its most negative speed [N]: 0, or negative for a reversible rotor.
inline double least_thrust(const RotorInfo& rotor) {
  const double speed = rotor.min_speed;
  return speed < 0.0 ? -(rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT] * speed * speed) : 0.0;
}

/// The speed [rad/s] for a thrust [N] within a rotor's limits.
/// @param least         least_thrust()
/// @param per_constant  1 / k_f
template <class Real>
SKYBODY_INLINE Real speed_for(const Real& thrust, double least, double per_constant) {
  if (!(least < 0.0)) return sqrt(thrust * per_constant);
  return copysign(sqrt(abs(thrust) * per_constant), thrust);
}

/// The robot's rotors. @throws std::runtime_error if there are none or one of them has no thrust
inline View<RotorInfo> working_rotors(const Setup& setup, int robot, const std::string& mode) {
  const View<RotorInfo> rotors = setup.rotors_of(robot);
  if (rotors.size() == 0) {
    refuse("robot `", robot_name(setup, robot), "` has no rotors, which ", mode,
           " needs: give it a rotors file, or use controller `wrench`");
  }
  for (const RotorInfo& rotor : rotors) {
    if (!(full_thrust(rotor) > 0.0)) {
      refuse("rotor `", rotor.name, "` has no thrust (thrust_constant ",
             rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT], ", max_speed ",
             rotor.constants[SKYBODY_ROTOR_MAX_SPEED],
             "): both must be above 0 in the robot's rotors file");
    }
  }
  return rotors;
}

/// Throws if a rotor is not fixed to the robot's base. @param remedy  end of the message
/// @throws std::runtime_error
inline void require_on_base(const Setup& setup, int robot, const View<RotorInfo>& rotors,
                            const std::string& remedy) {
  for (const RotorInfo& rotor : rotors) {
    if (rotor.body == base_of(setup, robot)) continue;
    refuse("rotor `", rotor.name, "` sits behind a joint, on `", setup.bodies()[rotor.body].name,
           "`", remedy);
  }
}

/// Throws if the robot's base is fixed. @param who  such as "`rail` cannot move"
/// @throws std::runtime_error
inline void require_floating_base(const Setup& setup, int robot, const std::string& who) {
  if (setup.robots()[robot].fixed_base == 0) return;
  refuse("robot `", robot_name(setup, robot), "` has a fixed base, which ", who,
         ": use a floating base in its URDF");
}

/// Throws if action -1 would be below a rotor's least value. @throws std::runtime_error
inline void require_reachable(const std::string& name, double low, double least,
                              const RotorInfo& rotor) {
  if (low >= least) return;
  refuse("`", name, "` ", low, " is below ", least, ", the least of rotor `", rotor.name,
         "`: raise it, or give the rotor a `min_speed` below 0 in its rotors file if it turns "
         "backwards");
}

/// Throws if a joint controller has no joints to drive. @throws std::runtime_error
inline void require_joints(const Setup& setup, int robot, const std::vector<std::string>& names) {
  if (!names.empty()) return;
  std::string known;
  for (const BodyInfo& body : setup.bodies()) {
    if (body.robot != robot || body.joint == SKYBODY_WELD || body.joint == SKYBODY_FREE) continue;
    known += (known.empty() ? "" : ", ") + std::string(body.joint_name);
  }
  refuse("`joints` names no joint to drive: robot `", robot_name(setup, robot), "` has ",
         (known.empty()
              ? "none. Take a controller of rotors, such as `srt`, or of the base, such as `wrench`"
              : "the joints " + known));
}

/// Throws unless low < high, with both values in the message. @throws std::runtime_error
inline void require_order(const std::string& low_name, double low, const std::string& high_name,
                          double high) {
  if (low < high) return;
  refuse("`", low_name, "` ", low, " is not below `", high_name, "` ", high,
         ": lower the first or raise the second");
}
/// The same for the corners of a box. @param low_name, high_name  of parameters with three values
inline void require_order(const std::string& low_name, const Vec3<double>& low,
                          const std::string& high_name, const Vec3<double>& high) {
  require_order(low_name + "[0]", low.x, high_name + "[0]", high.x);
  require_order(low_name + "[1]", low.y, high_name + "[1]", high.y);
  require_order(low_name + "[2]", low.z, high_name + "[2]", high.z);
}

}  // namespace skybody::control
