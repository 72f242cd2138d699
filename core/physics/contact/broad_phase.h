// Broad phase: finds the pairs that may touch within a step, and the number of substeps that they
// need, in the environments of one Real. On double and packs.
#pragma once

#include "core/physics/contact/contact_workspace.h"

namespace skybody {

/// Maximum number of substeps of a step.
inline constexpr int kMaxContactSubsteps = 64;

/// @tparam Values  access to constants: a pointer, or a view (lane_values.h)
template <class Real, class Values>
class BroadPhase {
 public:
  using Motion = BodyKinematics<Real>;

  SKYBODY_INLINE BroadPhase(const ContactScene& scene, const Values& obstacles,
                            const ContactWorkspace<Real>& work)
      : scene_(scene), obstacles_(obstacles), w_(work) {}

  /// Finds the pairs that may touch within the coming step, by bounding spheres about the bodies'
  /// origins. Bodies that are far from everything then need no rotation. Obstacles are left to
  /// measure() if clearances are kept. Pairs without a moving body are skipped.
  /// @param motion  motion(body): the BodyTravel of a contact body
  /// @param up      up(body): W's z axis in its frame
  /// @param wanted  lanes to test
  /// @param clearances  per contact body; null: not kept
  /// @param found   found(m, lanes): called for each pair that is near
  /// @returns the lanes that need measure()
  template <class MotionOf, class UpOf, class Found>
  SKYBODY_INLINE MaskOf<Real> find_near(const MotionOf& motion, const UpOf& up,
                                        const MaskOf<Real>& wanted,
                                        const Clearance<Real>* clearances,
                                        const Found& found) const {
    bound_about_origins(motion);
    MaskOf<Real> is_unclear(false);
    each_moving_pair([&](int m, const CollisionPair& pair, bool is_first) SKYBODY_INLINE_LAMBDA {
      const BodyBound<Real>& bound = w_.bounds[pair.body];
      if (pair.other == kGround) {
        const auto is_low = logical_and(wanted, bound.center.z < bound.radius);
        if (none(is_low)) return;
        const ContactBody& body = scene_.bodies[static_cast<std::size_t>(pair.body)];
        found(m, logical_and(is_low, may_reach_ground(body, bound, up(body))));
      } else if (pair.other >= 0) {
        found(m, logical_and(wanted, is_within(pair, bound)));
      } else if (clearances == nullptr) {
        found(m, logical_and(wanted, distance_of(pair, bound.center) < bound.radius));
      } else if (is_first) {
        const auto is_clear = is_clear_of(bound, clearances[pair.body]);
        is_unclear |= logical_and(wanted, logical_not(is_clear));
      }
    });
    return is_unclear;
  }

  /// The same for obstacles, in the lanes that find_near() returned.
  /// @param clearances  updated
  template <class MotionOf, class Found>
  SKYBODY_INLINE void measure(const MotionOf& motion, const MaskOf<Real>& wanted,
                              Clearance<Real>* clearances, const Found& found) const {
    bound_about_origins(motion);
    MaskOf<Real> is_clear(true);  // of all obstacles, for the body of the current pairs
    each_moving_pair([&](int m, const CollisionPair& pair, bool is_first) SKYBODY_INLINE_LAMBDA {
      if (!is_obstacle(pair.other)) return;
      const BodyBound<Real>& bound = w_.bounds[pair.body];
      Clearance<Real>& clearance = clearances[pair.body];
      if (is_first) {
        is_clear = is_clear_of(bound, clearance);
        clearance.at = select(is_clear, clearance.at, bound.center);
        clearance.distance = select(is_clear, clearance.distance, Real(kInfinity));
      }
      const auto may =
          logical_and(logical_not(is_clear), may_be_within(pair, bound.center, clearance.distance));
      if (none(may)) return;
      const Real distance = distance_of(pair, bound.center);
      found(m, logical_and(logical_and(wanted, may), distance < bound.radius));
      clearance.distance = select(is_clear, clearance.distance, min(distance, clearance.distance));
    });
  }

  /// Finds the shapes that may touch within the coming step. A motion that is not finite has no
  /// near pairs.
  /// @param motion  of all bodies: position, axes, velocity, angular velocity
  /// @param near_of  near_of(m): lanes in which to test pair m
  /// @returns the lanes with at least one near pair
  template <class NearOf>
  SKYBODY_INLINE MaskOf<Real> search(const Motion* motion, const NearOf& near_of) {
    bound(motion);
    MaskOf<Real> is_near(false);
    near_count_ = 0;
    may_stop_ = false;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) w_.is_body_near[i] = MaskOf<Real>(false);
    parts_ = Real(1.0);
    int m = -1;
    for (const CollisionPair& pair : scene_.pairs) {
      MaskOf<Real> here = near_of(++m);
      if (none(here)) continue;
      const BodyBound<Real>& bound = w_.bounds[pair.body];
      here = logical_and(here, pair.other == kGround ? is_near_ground(pair, bound, motion)
                                                     : is_within(pair, bound));
      if (none(here)) continue;
      if (pair.other == kGround) {
        add_pair(pair, 0, 0, here, Real(kInfinity));
      } else {
        here = near_shapes(pair, here, motion);
        if (none(here)) continue;
      }
      is_near |= here;
      w_.is_body_near[pair.body] |= here;
      if (pair.other >= 0) w_.is_body_near[pair.other] |= here;
    }
    return is_near;
  }

  /// Number of substeps of the step in each lane: a whole number.
  SKYBODY_INLINE const Real& parts() const { return parts_; }

 protected:
  double dt() const { return scene_.world.scenario.stepping.dt; }
  const ContactBody& other_body(const CollisionPair& pair) const {
    return scene_.bodies[static_cast<std::size_t>(pair.other)];
  }

  /// Calls f(m, pair, is_first) for the pairs in which at least one body moves. The pairs of one
  /// body with obstacles are contiguous; is_first marks the first of them.
  template <class F>
  SKYBODY_INLINE void each_moving_pair(const F& f) const {
    int m = -1, last = -1;
    for (const CollisionPair& pair : scene_.pairs) {
      ++m;
      if (!pair.moves) continue;
      const bool is_first = is_obstacle(pair.other) && pair.body != last;
      if (is_first) last = pair.body;
      f(m, pair, is_first);
    }
  }

  /// Margin for accelerations within a step: 2000 m/s^2 at 1 ms [m].
  static constexpr double kMargin = 1e-3;
  static constexpr double kGroundMargin = 1e-4;

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

  template <class MotionOf>
  SKYBODY_INLINE void bound_about_origins(const MotionOf& motion) const {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      w_.bounds[i] = bound_about_origin(scene_.bodies[i], motion(scene_.bodies[i]));
    }
  }
  SKYBODY_INLINE BodyBound<Real> bound_about_origin(const ContactBody& body,
                                                    const BodyTravel<Real>& m) const {
    const Real speed = size_of(m.velocity) + body.reach * size_of(m.spin);
    return {m.position, (body.reach + kMargin) + dt() * speed, speed};
  }

  /// Whether a body is clear of all obstacles. Otherwise its clearance must be measured from here.
  static SKYBODY_INLINE MaskOf<Real> is_clear_of(const BodyBound<Real>& bound,
                                                 const Clearance<Real>& clearance) {
    // Distances change at most as fast as the body moves.
    const Real moved = size_of(bound.center - clearance.at);
    return moved + bound.radius + 1e-9 < clearance.distance;
  }

  /// Whether an obstacle may be nearer to a point than a distance: by its bounding sphere.
  SKYBODY_INLINE MaskOf<Real> may_be_within(const CollisionPair& pair, const Vec3<Real>& point,
                                            const Real& distance) const {
    const Values c = obstacle_constants(pair.other);
    const Vec3<Real> apart = point - load_vec3(c + kShapePosition);
    const Real reach = c[kShapeReach] + distance;
    return logical_and(reach > 0.0, dot(apart, apart) < reach * reach);
  }

  /// Distance of a point from the box about an obstacle.
  SKYBODY_INLINE Real distance_of(const CollisionPair& pair, const Vec3<Real>& point) const {
    return norm(outside(pair, point)) - obstacle_constants(pair.other)[kShapeRounding];
  }

  /// Vector from the box about an obstacle to a point, in the obstacle's axes.
  SKYBODY_INLINE Vec3<Real> outside(const CollisionPair& pair, const Vec3<Real>& point) const {
    const Values c = obstacle_constants(pair.other);
    const Vec3<Real> half = load_vec3(c + kShapeHalf);
    const Vec3<Real> local = transpose_times(load_axes(c), point - load_vec3(c + kShapePosition));
    return {beyond(local.x, half.x), beyond(local.y, half.y), beyond_top(pair, local.z, half.z)};
  }

  /// An upper bound of the norm.
  static SKYBODY_INLINE Real size_of(const Vec3<Real>& v) {
    return (abs(v.x) + abs(v.y)) + abs(v.z);
  }

  /// Whether a body is near another body or an obstacle.
  SKYBODY_INLINE MaskOf<Real> is_within(const CollisionPair& pair,
                                        const BodyBound<Real>& bound) const {
    if (is_obstacle(pair.other)) {
      const auto may = may_be_within(pair, bound.center, bound.radius);
      if (none(may)) return may;
      const Vec3<Real> apart = outside(pair, bound.center);
      const Real reach = bound.radius + obstacle_constants(pair.other)[kShapeRounding];
      return may & logical_and(reach > 0.0, dot(apart, apart) < reach * reach);
    }
    const BodyBound<Real>& other = w_.bounds[pair.other];
    const Vec3<Real> apart = bound.center - other.center;
    const Real reach = bound.radius + other.radius;
    return dot(apart, apart) < reach * reach;
  }

  SKYBODY_INLINE MaskOf<Real> is_near_ground(const CollisionPair& pair,
                                             const BodyBound<Real>& bound,
                                             const Motion* motion) const {
    const auto is_low = bound.center.z < bound.radius;
    if (none(is_low)) return is_low;
    const ContactBody& body = scene_.bodies[static_cast<std::size_t>(pair.body)];
    const Motion& m = motion[body.body];
    const Real lowest = m.position.z + lowest_of(body, m.axes.row(2));
    return logical_and(is_low, lowest < dt() * bound.speed + kGroundMargin);
  }
  /// The same, for a bound about the body's origin: true wherever is_near_ground() is, and rarely
  /// in other lanes.
  /// @param up  W's z axis in its frame
  SKYBODY_INLINE MaskOf<Real> may_reach_ground(const ContactBody& body,
                                               const BodyBound<Real>& bound,
                                               const Vec3<Real>& up) const {
    // Twice the speed: the other bound sums different components of the velocity. 1e-9: its
    // round-off.
    return bound.center.z + lowest_of(body, up) <
           dt() * (2.0 * bound.speed) + (kGroundMargin + 1e-9);
  }
  /// Lowest of all points of a body, relative to its origin [m].
  static SKYBODY_INLINE Real lowest_of(const ContactBody& body, const Vec3<Real>& up) {
    Real lowest(kInfinity);
    for (const GroundPoint& p : body.points) {
      lowest = min(lowest, dot(up, to_real<Real>(p.at)) - p.radius);
    }
    for (const GroundRim& rim : body.rims) lowest = min(lowest, lowest_of_rim(rim, up));
    return lowest;
  }

  /// Narrows a pair of two bodies, or of a body and an obstacle, with near spheres down to its
  /// shapes.
  /// @returns the lanes in which any two shapes are near
  SKYBODY_INLINE MaskOf<Real> near_shapes(const CollisionPair& pair, const MaskOf<Real>& within,
                                          const Motion* motion) {
    Real way = dt() * w_.bounds[pair.body].speed;
    if (pair.other >= 0) way += dt() * w_.bounds[pair.other].speed;
    MaskOf<Real> is_near(false);
    each_two_shapes(
        pair, motion,
        [&](int s, int t, const PlacedShape<Real>& placed, const PlacedShape<Real>& other)
            SKYBODY_INLINE_LAMBDA {
              const ContactShape& model = scene_.shapes[static_cast<std::size_t>(s)];
              const auto here = logical_and(within, is_close(model, placed, other, way + kMargin));
              if (none(here)) return;
              is_near |= here;
              const Real least = min(penetration_limit(placed.half, placed.rounding),
                                     penetration_limit(other.half, other.rounding));
              const Real give = pair.is_unbounded_below ? Real(kInfinity) : least;
              add_pair(pair, s, t, here, give);
              // A stopped shape must not have passed through before.
              ask_for(2.0 * way / give, here);
            });
    return is_near;
  }

  /// Whether a shape may be nearer to another one than a distance. Test: the plane through the
  /// nearest point of the other's surface has the whole shape behind it.
  /// @param model  of the first shape
  static SKYBODY_INLINE MaskOf<Real> is_close(const ContactShape& model,
                                              const PlacedShape<Real>& placed,
                                              const PlacedShape<Real>& other,
                                              const Real& distance) {
    const SurfaceDistance<Real> apart = other.distance(other.to_local(placed.position));
    // The test does not hold for shapes that are not convex.
    const Real reach = other.type == ShapeType::kHeightField
                           ? Real(model.reach)
                           : placed.extent(other.axes * apart.normal);
    return apart.distance < reach + distance;
  }

  /// Calls f(s, t, placed, other) for the shapes of a pair at their poses.
  template <class F>
  SKYBODY_INLINE void each_two_shapes(const CollisionPair& pair, const Motion* motion,
                                      const F& f) const {
    const ContactBody& body = scene_.bodies[static_cast<std::size_t>(pair.body)];
    const bool is_body = pair.other >= 0;
    const int first = is_body ? other_body(pair).first_shape : obstacle_of(pair.other);
    const int last = is_body ? other_body(pair).last_shape : first + 1;
#pragma GCC unroll 1
    for (int t = first; t < last; ++t) {
      const PlacedShape<Real> other = other_placed_shape(pair, t, motion);
#pragma GCC unroll 1
      for (int s = body.first_shape; s < body.last_shape; ++s) {
        f(s, t, placed_shape_of(scene_.shapes[static_cast<std::size_t>(s)], motion[body.body]),
          other);
      }
    }
  }

  SKYBODY_INLINE void add_pair(const CollisionPair& pair, int shape, int other,
                               const MaskOf<Real>& here, const Real& give) {
    w_.near[near_count_++] = {&pair, shape, other, here, give, Real(0.0), Real(0.0), false};
    may_stop_ |= !pair.is_unbounded_below;
  }

  static SKYBODY_INLINE PlacedShape<Real> placed_shape_of(const ContactShape& placed,
                                                          const Motion& m) {
    return {placed.type,
            m.position + m.axes * to_real<Real>(placed.pose.position),
            m.axes * to_mat3(to_real<Real>(placed.pose.rotation)),
            to_real<Real>(placed.half),
            Real(placed.rounding),
            placed.heights};
  }
  /// A shape of the other body, or the obstacle.
  SKYBODY_INLINE PlacedShape<Real> other_placed_shape(const CollisionPair& pair, int t,
                                                      const Motion* motion) const {
    if (pair.other >= 0) {
      return placed_shape_of(scene_.shapes[static_cast<std::size_t>(t)],
                             motion[other_body(pair).body]);
    }
    const Values c = obstacle_constants(pair.other);
    const ContactShape& model = scene_.obstacles[static_cast<std::size_t>(t)];
    return {model.type,
            load_vec3(c + kShapePosition),
            load_axes(c),
            load_vec3(c + kShapeHalf),
            Real(c[kShapeRounding]),
            model.heights};
  }

  /// Distance of a coordinate beyond an edge; NaN stays NaN.
  static SKYBODY_INLINE Real beyond(const Real& x, const Real& half) {
    const Real over = abs(x) - half;
    return select(over < Real(0.0), Real(0.0), over);
  }

  /// The same along z; unbounded shapes have no lower edge.
  static SKYBODY_INLINE Real beyond_top(const CollisionPair& pair, const Real& z,
                                        const Real& half) {
    if (!pair.is_unbounded_below) return beyond(z, half);
    const Real over = z - half;
    return select(over < Real(0.0), Real(0.0), over);
  }

  /// Raises the number of substeps to the wanted one, rounded up to a power of two.
  SKYBODY_INLINE void ask_for(const Real& wanted, const MaskOf<Real>& here) {
    for (int parts = 2; parts <= kMaxContactSubsteps; parts *= 2) {
      const auto more = logical_and(here, wanted > 0.5 * parts);
      if (none(more)) break;
      parts_ = select(logical_and(more, parts_ < parts), Real(parts), parts_);
    }
  }

  SKYBODY_INLINE Values obstacle_constants(int other) const {
    return obstacles_ + kShapeConstantCount * obstacle_of(other);
  }
  static SKYBODY_INLINE Mat3<Real> load_axes(const Values& c) {
    Mat3<Real> axes;
    for (int k = 0; k < 9; ++k) axes.m[k] = c[kShapeAxes + k];
    return axes;
  }

  const ContactScene& scene_;
  Values obstacles_;
  ContactWorkspace<Real> w_;
  int near_count_ = 0;
  bool may_stop_ = false;  ///< a near pair limits penetration and stops the bodies there
  Real parts_{1.0};
};

}  // namespace skybody
