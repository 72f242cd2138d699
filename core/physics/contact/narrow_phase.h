// Narrow phase: the contact points of the pairs that may touch, in the environments of one Real. On
// double and packs.
#pragma once

#include "core/physics/contact/broad_phase.h"
#include "core/physics/contact/manifold.h"

namespace skybody {

/// Contact points of the pairs that the broad phase has found near.
/// @tparam Values  access to constants: a pointer, or a view (lane_values.h)
template <class Real, class Values>
class NarrowPhase : public BroadPhase<Real, Values> {
  using Search = BroadPhase<Real, Values>;

 public:
  using Motion = BodyKinematics<Real>;
  using Search::Search;

 protected:
  using Search::near_count_;
  using Search::other_placed_shape;
  using Search::placed_shape_of;
  using Search::scene_;
  using Search::w_;

  /// Forgets the contact points of the last substep.
  SKYBODY_INLINE void forget_places() { are_places_kept_ = false; }
  /// Whether all contact points of the substep are known, and no body has more than kLeastPlaces.
  bool are_few() const { return are_places_kept_ && place_count_ <= kLeastPlaces; }

  /// Calls f(place) for the contact points.
  template <class F>
  SKYBODY_INLINE void each_place(const Motion* motion, const MaskOf<Real>& is_active, const F& f) {
    const bool are_known = are_places_kept_;
    int next = are_known ? near_count_ : 0;
    do {
      if (!are_known) next = find_places(motion, next, is_active);
#pragma GCC unroll 1
      for (int i = 0; i < place_count_; ++i) f(w_.places[i]);
    } while (next < near_count_);
  }

 private:
  using Search::is_close;

  /// Computes contact points of the pairs from `next` on, up to kKeptPlaces.
  /// @returns the index of the first pair that is left
  SKYBODY_INLINE int find_places(const Motion* motion, int next, const MaskOf<Real>& is_active) {
    Manifold<Real> found{w_.places};
    const bool is_first = next == 0;
    for (; next < near_count_ && found.count <= kKeptPlaces; ++next) {
      CandidatePair<Real>& near = w_.near[next];
      const auto here = logical_and(is_active, near.lanes);
      near.touches = false;
      if (none(here)) continue;
      const int first = found.count;
      if (near.pair->other == kGround) {
        collide_ground(*near.pair, motion, here, found);
      } else {
        collide_shapes(near, motion, here, found);
      }
      for (int i = first; i < found.count; ++i) found.places[i].pair = next;
      near.touches = found.count > first;
    }
    place_count_ = found.count;
    are_places_kept_ = is_first && next == near_count_;
    return next;
  }

  SKYBODY_INLINE void collide_ground(const CollisionPair& pair, const Motion* motion,
                                     const MaskOf<Real>& here, Manifold<Real>& found) const {
    const ContactBody& body = scene_.bodies[static_cast<std::size_t>(pair.body)];
    const Motion& m = motion[body.body];
    const Vec3<Real> up{Real(0.0), Real(0.0), Real(1.0)};
#pragma GCC unroll 1
    for (const GroundPoint& point : body.points) {
      const Vec3<Real> at = to_real<Real>(point.at);
      const Real z = (m.position.z + dot(m.axes.row(2), at)) - point.radius;
      const auto touches = logical_and(here, z < 0.0);
      if (none(touches)) continue;  // most points of a resting body are not in contact
      found.add({m.position.x + dot(m.axes.row(0), at), m.position.y + dot(m.axes.row(1), at), z},
                up, -z, point.bristle, touches);
    }
    for (const GroundRim& rim : body.rims) {
      const auto may = logical_and(here, m.position.z + lowest_of_rim(rim, m.axes.row(2)) < 0.0);
      if (none(may)) continue;
      each_ground_place(rim, m, [&](const Vec3<Real>& place, int bristle) SKYBODY_INLINE_LAMBDA {
        found.add(place, up, -place.z, bristle, logical_and(may, place.z < 0.0));
      });
    }
  }

  SKYBODY_INLINE void collide_shapes(const CandidatePair<Real>& near, const Motion* motion,
                                     const MaskOf<Real>& here, Manifold<Real>& found) const {
    const CollisionPair& pair = *near.pair;
    const auto& others = pair.other >= 0 ? scene_.shapes : scene_.obstacles;
    const ContactShape& mine = scene_.shapes[static_cast<std::size_t>(near.shape)];
    const PlacedShape<Real> placed =
        placed_shape_of(mine, motion[scene_.bodies[static_cast<std::size_t>(pair.body)].body]);
    const PlacedShape<Real> other = other_placed_shape(pair, near.other, motion);
    const auto touches = logical_and(here, is_close(mine, placed, other, Real(1e-9)));
    if (none(touches)) return;
    collide(CollideCall<Real>{mine, others[static_cast<std::size_t>(near.other)], placed, other,
                              touches, found});
  }

  int place_count_ = 0;           ///< number of entries in ContactWorkspace::places
  bool are_places_kept_ = false;  ///< these are all contact points of the current substep
};

}  // namespace skybody
