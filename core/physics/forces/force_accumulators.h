// Sums of the forces on one body, in two forms with one interface, so that each force term
// (force_terms.h) is written once. On double and packs.
//
// - OriginForceAccumulator: about the body's origin, W axes. For the tree's algorithms and Simbody.
// - FreeBodyForceAccumulator: acceleration of the centre of mass (W) and moment about it (body
//   axes). For the equations of one free body, with fewer rotations between the axes.
//
// The caller specifies the point of action and the axes of a force; each form converts as needed.
#pragma once

#include "core/physics/bodies/body_constants.h"
#include "core/physics/bodies/spatial_force.h"

namespace skybody {

/// Axes in which a vector is given.
enum class Axes { kWorld, kBody };

/// Adds to a SpatialForce. Refers to its arguments.
/// @tparam Params  access to the body's parameters: a pointer, or a view (lane_values.h)
template <class Real, class Params>
class OriginForceAccumulator {
 public:
  SKYBODY_INLINE OriginForceAccumulator(const BodyKinematics<Real>& body, const Params& body_params,
                                        SpatialForce<Real>& sum)
      : body_(body), params_(body_params), sum_(sum) {}

  SKYBODY_INLINE const Vec3<Real>& angular_velocity() const { return body_.angular_velocity; }
  /// The centre of mass in the body's frame.
  SKYBODY_INLINE Vec3<Real> com() const { return load_vec3(params_ + kCom); }

  /// Overwrites the sum with the body's weight.
  SKYBODY_INLINE void begin(const Vec3<Real>& gravity) {
    sum_.force = gravity * params_[kMass];
    sum_.moment = cross(com_arm(), sum_.force);
  }
  /// About the origin, body axes.
  SKYBODY_INLINE void add_in_body(const SpatialForce<Real>& force) {
    sum_.force += body_.axes * force.force;
    sum_.moment += body_.axes * force.moment;
  }
  /// About the origin, W axes.
  SKYBODY_INLINE void add_about_origin(const SpatialForce<Real>& force) {
    sum_.force += force.force;
    sum_.moment += force.moment;
  }
  SKYBODY_INLINE void add_at_com(const Vec3<Real>& force, Axes axes) {
    sum_.add_force_at(com_arm(), in_world(force, axes));
  }
  /// @param point  in the body's frame
  SKYBODY_INLINE void add_at_point(const Vec3<Real>& point, const Vec3<Real>& force, Axes axes) {
    sum_.add_force_at(body_.axes * point, in_world(force, axes));
  }
  /// At the centre of mass, body axes.
  SKYBODY_INLINE void add_drag(const Vec3<Real>& force) { add_at_com(force, Axes::kBody); }
  SKYBODY_INLINE void add_moment(const Vec3<Real>& moment, Axes axes) {
    sum_.moment += in_world(moment, axes);
  }
  /// Calls `add` for the lanes of a mask. Other lanes keep their sums bit for bit: adding +0 would
  /// change a -0.
  template <class Add>
  SKYBODY_INLINE void add_where(const MaskOf<Real>& mask, const Add& add) {
    const SpatialForce<Real> before = sum_;
    add(*this);
    sum_.force = select(mask, sum_.force, before.force);
    sum_.moment = select(mask, sum_.moment, before.moment);
  }

 private:
  SKYBODY_INLINE Vec3<Real> com_arm() const { return body_.axes * com(); }
  SKYBODY_INLINE Vec3<Real> in_world(const Vec3<Real>& v, Axes axes) const {
    return axes == Axes::kWorld ? v : body_.axes * v;
  }

  const BodyKinematics<Real>& body_;
  Params params_;
  SpatialForce<Real>& sum_;
};

/// Known structure of a free body's constants: allows shorter formulas with the same values.
struct InertiaStructure {
  bool is_axial = false;         ///< the centre of mass is on the body's z axis
  bool has_no_products = false;  ///< of inertia, nor of its inverse
};

/// Rates of a free body: of its origin's velocity (W) and of its spin (body axes).
template <class Real>
struct FreeAcceleration {
  Vec3<Real> velocity, spin;
};

/// The same before its parts are converted to one frame.
template <class Real>
struct FreeRates {
  Vec3<Real> in_world, in_body;  ///< their sum is the velocity's rate
  Vec3<Real> spin;               ///< body axes

  SKYBODY_INLINE FreeAcceleration<Real> acceleration(const Mat3<Real>& axes) const {
    return {in_world + axes * in_body, spin};
  }
  /// The velocity's rate in body axes.
  /// @param is_upright  `in_world` is known to lie along z, as gravity does in most scenarios
  SKYBODY_INLINE Vec3<Real> velocity_in_body(const Mat3<Real>& axes, bool is_upright) const {
    const Vec3<Real> upright = axes.row(2) * in_world.z;
    if (is_upright) return in_body + upright;
    const auto is_oblique = logical_or(in_world.x != 0.0, in_world.y != 0.0);
    return in_body + select(is_oblique, transpose_times(axes, in_world), upright);
  }
};

/// Newton-Euler equations about the centre of mass of one free body (docs/dynamics.md, One
/// free body).
/// Refers to its arguments.
/// @tparam Constants  access to the kBodyConstantCount values: a pointer, or a view
template <class Real, class Constants>
class FreeBodyForceAccumulator {
 public:
  /// @param gravity  [m/s^2], W; it acts at the centre of mass and so causes no moment
  /// @param rotors   about the origin, body axes
  SKYBODY_INLINE FreeBodyForceAccumulator(const BodyKinematics<Real>& body,
                                          const Constants& constants, const InertiaStructure& known,
                                          const Vec3<Real>& gravity,
                                          const SpatialForce<Real>& rotors)
      : body_(body),
        constants_(constants),
        known_(known),
        inverse_mass_(constants[kBodyInverseMass]),
        com_(load_vec3(constants + kBodyCom)),
        linear_(gravity),
        force_(rotors.force) {
    const Vec3<Real>&m = rotors.moment, &f = rotors.force;
    const Vec3<Real> on_axis{m.x + com_.z * f.y, m.y - com_.z * f.x, m.z};
    moment_ = by_com(on_axis, [&]() SKYBODY_INLINE_LAMBDA { return m - cross(com_, f); });
  }

  SKYBODY_INLINE Vec3<Real> angular_velocity() const { return body_.axes * body_.spin; }
  SKYBODY_INLINE const Vec3<Real>& com() const { return com_; }

  /// About the origin, W axes.
  SKYBODY_INLINE void add_about_origin(const SpatialForce<Real>& force) {
    linear_ += force.force * inverse_mass_;
    moment_ += transpose_times(body_.axes, force.moment) -
               cross(com_, transpose_times(body_.axes, force.force));
  }
  SKYBODY_INLINE void add_at_com(const Vec3<Real>& force, Axes axes) {
    const Vec3<Real> acceleration = force * inverse_mass_;
    linear_ += axes == Axes::kWorld ? acceleration : body_.axes * acceleration;
  }
  /// @param point  in the body's frame
  SKYBODY_INLINE void add_at_point(const Vec3<Real>& point, const Vec3<Real>& force, Axes axes) {
    add_at_com(force, axes);
    moment_ += cross(point - com_, in_body(force, axes));
  }
  /// At the centre of mass, body axes: part of the sum that contains the rotors' force.
  SKYBODY_INLINE void add_drag(const Vec3<Real>& force) { force_ += force; }
  SKYBODY_INLINE void add_moment(const Vec3<Real>& moment, Axes axes) {
    moment_ += in_body(moment, axes);
  }
  /// As OriginForceAccumulator::add_where.
  template <class Add>
  SKYBODY_INLINE void add_where(const MaskOf<Real>& mask, const Add& add) {
    const Vec3<Real> linear = linear_, moment = moment_, force = force_;
    add(*this);
    force_ = select(mask, force_, force);
    linear_ = select(mask, linear_, linear);
    moment_ = select(mask, moment_, moment);
  }

  SKYBODY_INLINE FreeAcceleration<Real> acceleration() const {
    return rates().acceleration(body_.axes);
  }
  SKYBODY_INLINE FreeRates<Real> rates() const {
    const Vec3<Real>& w = body_.spin;
    const Vec3<Real> momentum = times(kBodyInertia, w);
    const Vec3<Real> angular = times(kBodyInverseInertia, moment_ - cross(w, momentum));
    const Vec3<Real> axial{com_.z * (angular.y + w.x * w.z), com_.z * (w.y * w.z - angular.x),
                           -(com_.z * (w.x * w.x + w.y * w.y))};
    const Vec3<Real> com_from_origin = by_com(axial, [&]() SKYBODY_INLINE_LAMBDA {
      return cross(angular, com_) + cross(w, cross(w, com_));
    });
    return {linear_, force_ * inverse_mass_ - com_from_origin, angular};
  }

 private:
  SKYBODY_INLINE Vec3<Real> in_body(const Vec3<Real>& v, Axes axes) const {
    return axes == Axes::kBody ? v : transpose_times(body_.axes, v);
  }

  /// `on_axis` in lanes with the centre of mass on the body's z axis, the usual case; general() in
  /// the others.
  template <class General>
  SKYBODY_INLINE Vec3<Real> by_com(const Vec3<Real>& on_axis, const General& general) const {
    if (known_.is_axial) return on_axis;
    const auto is_off = logical_or(com_.x != 0.0, com_.y != 0.0);
    if (none(is_off)) return on_axis;
    return select(is_off, general(), on_axis);
  }

  /// A symmetric matrix of the constants times v. Products of inertia are mostly zero.
  SKYBODY_INLINE Vec3<Real> times(int matrix, const Vec3<Real>& v) const {
    const SymMat3<Real> m = load_sym_mat3(constants_ + matrix);
    const Vec3<Real> diagonal{m.xx * v.x, m.yy * v.y, m.zz * v.z};
    if (known_.has_no_products) return diagonal;
    const auto has_products = is_not_zero(Vec3<Real>{m.xy, m.xz, m.yz});
    if (none(has_products)) return diagonal;
    return select(has_products, m * v, diagonal);
  }

  const BodyKinematics<Real>& body_;
  Constants constants_;
  InertiaStructure known_;
  Real inverse_mass_;
  Vec3<Real> com_;
  Vec3<Real> linear_;  ///< acceleration of the centre of mass by all other forces, W
  Vec3<Real> moment_;  ///< about the centre of mass, body axes
  Vec3<Real> force_;   ///< of the rotors and of drag, body axes
};

}  // namespace skybody
