// What a step in contact works on: arrays in a thread's scratch memory.
#pragma once

#include "core/physics/bodies/kinematics.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/contact/contact_scene.h"
#include "core/physics/contact/manifold.h"

namespace skybody {

/// A contact body's sphere during one step.
template <class Real>
struct BodyBound {
  Vec3<Real> center;  ///< at the step's start, W [m]
  Real radius;        ///< with the way that the centre goes within the step [m]
  Real speed;         ///< no place of the body is faster [m/s]
};

/// How a body's origin moves, for its bound.
template <class Real>
struct BodyWay {
  Vec3<Real> position, velocity;  ///< W [m, m/s]
  Vec3<Real> spin;                ///< in any axes [rad/s]
};

/// How far a body's origin was from all obstacles, where it was looked at last.
template <class Real>
struct Clearance {
  Vec3<Real> at;  ///< W [m]
  Real distance;  ///< less than nothing: not looked at so far [m]
};

/// What the contacts of a step that were stopped did so far to a body's motion.
template <class Real>
struct BodyVelocityChange {
  Vec3<Real> velocity;          ///< of the centre of mass, W [m/s]
  Vec3<Real> angular_velocity;  ///< W [rad/s]
};

/// A body that is near the ground, or a placed of one that is near another placed.
template <class Real>
struct CandidatePair {
  const CollisionPair* pair;
  int shape, other;  ///< of ContactScene::shapes, and of its obstacles or shapes; unset: the ground
  MaskOf<Real> lanes;  ///< where they are near
  Real give;           ///< how deep they get into each other at most [m]
  Real per_mass;       ///< inverse of the mass that a place feels [1/kg]
  Real most_damping;   ///< see ContactKinematics; of the present part
  bool touches;        ///< in any lane, in the present part: the two above are known
};

/// Arrays of a step in contact, in a thread's scratch memory.
template <class Real>
struct ContactWorkspace {
  BodyBound<Real>* bounds = nullptr;          ///< per contact body
  SpatialForce<Real>* forces = nullptr;       ///< per body of the world: of its contacts
  BodyVelocityChange<Real>* kicks = nullptr;  ///< likewise
  Real* sums = nullptr;                       ///< likewise: see limited_force()
  Real* place_counts = nullptr;               ///< likewise: on how many places it touches anything
  Vec3<Real>* bristles = nullptr;             ///< all of the world
  Vec3<Real>* bent = nullptr;                 ///< the same after the part of the step
  MaskOf<Real>* is_bent = nullptr;            ///< per bristle: by a contact of this part
  bool* is_idle = nullptr;             ///< per bristle: all lanes have words of 0, untouched so far
  MaskOf<Real>* is_touched = nullptr;  ///< per body of the world: since begin()
  CandidatePair<Real>* near = nullptr;   ///< things that are near each other
  MaskOf<Real>* is_body_near = nullptr;  ///< per contact body: the lanes where any of these is its
  ContactPoint<Real>* places =
      nullptr;  ///< where they touch: kKeptPlaces, and room for one pair more
};

/// Takes nothing down.
struct NoContactList {
  template <class... Args>
  SKYBODY_INLINE void operator()(const Args&...) const {}
};

}  // namespace skybody
