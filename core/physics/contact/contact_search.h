// What is near enough to touch within a step, in the environments that one Real holds; and into how
// many parts that cuts the step. On double and packs.
#pragma once

#include "core/physics/contact/contact_work.h"

namespace skybody {

/// The most parts of a step.
inline constexpr int kMostParts = 64;

/// @tparam Values  how constants are read: a pointer, or a view (lane_values.h)
template <class Real, class Values>
class ContactSearch {
 public:
  using Motion = BodyKinematics<Real>;

  SKYBODY_INLINE ContactSearch(const ContactScene& scene, const Values& obstacles,
                               const ContactWork<Real>& work)
      : scene_(scene), obstacles_(obstacles), w_(work) {}

  /// Whether search() may find anything that moves: by spheres about the bodies' origins, so that
  /// nothing is to be turned.
  /// @param motion  of bodies with solids: position, velocity, spin
  /// @param clearances  per contact body: what is known of its distance from what stands still, in
  ///                    the lanes of `wanted`; brought up to date. Null: nothing is kept
  SKYBODY_INLINE MaskOf<Real> may_be_near(const Motion* motion, const MaskOf<Real>& wanted,
                                          Clearance<Real>* clearances) const {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const ContactBody& body = scene_.bodies[i];
      const Motion& m = motion[body.body];
      const double radius = body.radius + norm(body.center);
      const Real speed = size_of(m.velocity) + radius * size_of(m.spin);
      w_.bounds[i] = {m.position, (radius + kMargin) + dt() * speed, speed};
    }
    MaskOf<Real> is_near(false);
    int looked_at = -1;  // of the bodies, whose meetings follow one another
    bool is_clear = false;
    for (const Meeting& meeting : scene_.meetings) {
      if (!meeting.moves) continue;
      const BodyBound<Real>& bound = w_.bounds[meeting.body];
      if (meeting.other >= 0) {
        is_near |= is_within(meeting, bound);
        continue;
      }
      if (clearances != nullptr && meeting.body != looked_at) {
        looked_at = meeting.body;
        is_clear = look_at(bound, wanted, clearances[meeting.body]);
      }
      if (is_clear) continue;
      const Real distance = distance_of(meeting, bound.center);
      is_near |= distance < bound.radius;
      if (clearances == nullptr) continue;
      Real& least = clearances[meeting.body].distance;
      least = min(distance, least);
    }
    return is_near;
  }

  /// Looks for what may touch within the step that begins. A motion that is not finite is near
  /// nothing.
  /// @param motion  of all bodies: position, axes, velocity, angular velocity
  /// @returns the lanes where anything may
  SKYBODY_INLINE MaskOf<Real> search(const Motion* motion) {
    bound(motion);
    MaskOf<Real> is_near(false);
    near_count_ = 0;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) w_.is_body_near[i] = false;
    parts_ = Real(1.0);
    for (std::size_t i = 0; i < scene_.meetings.size(); ++i) {
      const Meeting& meeting = scene_.meetings[i];
      const BodyBound<Real>& bound = w_.bounds[meeting.body];
      const MaskOf<Real> here = meeting.other == kGround ? is_near_ground(meeting, bound, motion)
                                                         : is_within(meeting, bound);
      if (none(here)) continue;
      is_near |= here;
      w_.is_near[near_count_] = here;
      w_.is_body_near[meeting.body] = true;
      if (meeting.other >= 0) w_.is_body_near[meeting.other] = true;
      w_.near[near_count_++] = static_cast<int>(i);
      cut(meeting, here);
    }
    return is_near;
  }

  /// Into how many parts the step is to be cut, in each lane: a whole number.
  SKYBODY_INLINE const Real& parts() const { return parts_; }

 protected:
  double dt() const { return scene_.world.scenario.stepping.dt; }
  const ContactBody& other_body(const Meeting& meeting) const {
    return scene_.bodies[static_cast<std::size_t>(meeting.other)];
  }

  /// What acceleration adds to the way of a step: 2000 m/s^2 at 1 ms [m].
  static constexpr double kMargin = 1e-3;

  SKYBODY_INLINE void bound(const Motion* motion) const {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const ContactBody& body = scene_.bodies[i];
      const Motion& m = motion[body.body];
      const Vec3<Real> arm = m.axes * to_real<Real>(body.center);
      const Vec3<Real> v = m.velocity + cross(m.angular_velocity, arm);
      const Real speed = size_of(v);
      w_.bounds[i] = {m.position + arm, (body.radius + kMargin) + dt() * speed,
                      speed + body.radius * size_of(m.angular_velocity)};
    }
  }

  /// Whether a body is clear of all that stands still in the lanes of `wanted`. If not, it is to
  /// be measured from here: its clearance begins anew.
  SKYBODY_INLINE bool look_at(const BodyBound<Real>& bound, const MaskOf<Real>& wanted,
                              Clearance<Real>& clearance) const {
    // Distances grow and fall no quicker than the body moves.
    const Real moved = size_of(bound.center - clearance.at);
    if (none(logical_and(wanted, logical_not(moved + bound.radius + 1e-9 < clearance.distance)))) {
      return true;
    }
    clearance = {bound.center, Real(kInfinity)};
    return false;
  }

  /// Of a point from the ground, or from the box about an obstacle.
  SKYBODY_INLINE Real distance_of(const Meeting& meeting, const Vec3<Real>& point) const {
    if (meeting.other == kGround) return point.z;
    const Values c = obstacle_constants(meeting.other);
    const Vec3<Real> apart = point - load_vec3(c + kSolidPosition),
                     half = load_vec3(c + kSolidHalf);
    const Vec3<Real> local = transpose_times(load_axes(c), apart);
    const Vec3<Real> outside{beyond(local.x, half.x), beyond(local.y, half.y),
                             beyond_top(meeting, local.z, half.z)};
    return norm(outside) - c[kSolidRounding];
  }

  /// No less than the norm.
  static SKYBODY_INLINE Real size_of(const Vec3<Real>& v) {
    return (abs(v.x) + abs(v.y)) + abs(v.z);
  }

  /// Another body, or an obstacle.
  SKYBODY_INLINE MaskOf<Real> is_within(const Meeting& meeting,
                                        const BodyBound<Real>& bound) const {
    if (is_obstacle(meeting.other)) {
      const Values c = obstacle_constants(meeting.other);
      const Vec3<Real> apart = bound.center - load_vec3(c + kSolidPosition);
      const Mat3<Real> axes = load_axes(c);
      const Vec3<Real> local = transpose_times(axes, apart), half = load_vec3(c + kSolidHalf);
      const Vec3<Real> outside{beyond(local.x, half.x), beyond(local.y, half.y),
                               beyond_top(meeting, local.z, half.z)};
      const Real reach = bound.radius + c[kSolidRounding];
      return logical_and(reach > 0.0, dot(outside, outside) < reach * reach);
    }
    const BodyBound<Real>& other = w_.bounds[meeting.other];
    const Vec3<Real> apart = bound.center - other.center;
    const Real reach = bound.radius + other.radius;
    return dot(apart, apart) < reach * reach;
  }

  SKYBODY_INLINE MaskOf<Real> is_near_ground(const Meeting& meeting, const BodyBound<Real>& bound,
                                             const Motion* motion) const {
    const auto is_low = bound.center.z < bound.radius;
    if (none(is_low)) return is_low;
    const ContactBody& body = scene_.bodies[static_cast<std::size_t>(meeting.body)];
    const Motion& m = motion[body.body];
    const Vec3<Real> row = m.axes.row(2);
    Real lowest(kInfinity);
    for (const GroundPoint& p : body.points) {
      lowest = min(lowest, dot(row, to_real<Real>(p.at)) - p.radius);
    }
    for (const GroundRim& rim : body.rims) lowest = min(lowest, lowest_of_rim(rim, row));
    lowest += m.position.z;
    return logical_and(is_low, lowest < dt() * bound.speed + 1e-4);
  }

  /// How far a coordinate lies beyond an edge; NaN stays NaN.
  static SKYBODY_INLINE Real beyond(const Real& x, const Real& half) {
    const Real over = abs(x) - half;
    return select(over < Real(0.0), Real(0.0), over);
  }

  /// The same along z; what is endless reaches down without end.
  static SKYBODY_INLINE Real beyond_top(const Meeting& meeting, const Real& z, const Real& half) {
    if (!meeting.is_endless) return beyond(z, half);
    const Real over = z - half;
    return select(over < Real(0.0), Real(0.0), over);
  }

  /// Into how many parts a meeting cuts the step before it is known what touches: what is stopped
  /// must not have passed.
  SKYBODY_INLINE void cut(const Meeting& meeting, const MaskOf<Real>& here) {
    if (meeting.is_endless) return;
    Real speed = w_.bounds[meeting.body].speed;
    if (meeting.other >= 0) speed += w_.bounds[meeting.other].speed;
    ask_for(speed * (2.0 * dt()) / give_of_meeting(meeting), here);
  }

  SKYBODY_INLINE void ask_for(const Real& wanted, const MaskOf<Real>& here) {
    for (int parts = 2; parts <= kMostParts; parts *= 2) {
      const auto more = logical_and(here, wanted > 0.5 * parts);
      if (none(more)) break;
      parts_ = select(logical_and(more, parts_ < parts), Real(parts), parts_);
    }
  }

  SKYBODY_INLINE Real give_of_meeting(const Meeting& meeting) const {
    if (meeting.is_endless) return Real(kInfinity);
    const Real give(scene_.bodies[static_cast<std::size_t>(meeting.body)].give);
    if (meeting.other >= 0) return min(give, Real(other_body(meeting).give));
    const Values c = obstacle_constants(meeting.other);
    return min(give, give_of(load_vec3(c + kSolidHalf), Real(c[kSolidRounding])));
  }

  SKYBODY_INLINE Values obstacle_constants(int other) const {
    return obstacles_ + kSolidConstantCount * obstacle_of(other);
  }
  static SKYBODY_INLINE Mat3<Real> load_axes(const Values& c) {
    Mat3<Real> axes;
    for (int k = 0; k < 9; ++k) axes.m[k] = c[kSolidAxes + k];
    return axes;
  }

  const ContactScene& scene_;
  Values obstacles_;
  ContactWork<Real> w_;
  int near_count_ = 0;
  Real parts_{1.0};
};

}  // namespace skybody
