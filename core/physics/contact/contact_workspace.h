// Work arrays of a step with contact, in a thread's scratch memory.
#pragma once

#include "core/physics/bodies/kinematics.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/contact/contact_scene.h"
#include "core/physics/contact/manifold.h"

namespace skybody {

/// A contact body's bounding sphere during one step.
template <class Real>
struct BodyBound {
  Vec3<Real> center;  ///< at the step's start, W [m]
  Real radius;        ///< includes the motion of the centre within the step [m]
  Real speed;         ///< upper bound of the speed of all points of the body [m/s]
};

/// Motion of a body's origin, for its bound.
template <class Real>
struct BodyTravel {
  Vec3<Real> position, velocity;  ///< W [m, m/s]
  Vec3<Real> spin;                ///< in any axes [rad/s]
};

/// Distance of a body's origin from all obstacles at the position of the last measurement.
template <class Real>
struct Clearance {
  Vec3<Real> at;  ///< W [m]
  Real distance;  ///< negative: not measured yet [m]
};

/// Velocity change of a body by the stopped contacts of a step so far.
template <class Real>
struct BodyVelocityChange {
  Vec3<Real> velocity;          ///< of the centre of mass, W [m/s]
  Vec3<Real> angular_velocity;  ///< W [rad/s]
};

/// A body near the ground, or a shape of one body near another shape.
template <class Real>
struct CandidatePair {
  const CollisionPair* pair;
  int shape, other;    ///< in ContactScene::shapes, and in its obstacles or shapes; not set for the
                       ///< ground
  MaskOf<Real> lanes;  ///< lanes in which they are near
  Real give;           ///< limit of their penetration [m]
  Real per_mass;       ///< inverse of the mass per contact point [1/kg]
  Real most_damping;   ///< see ContactKinematics; of the current substep
  bool touches;  ///< in any lane, in the current substep: if true, the two values above are set
};

/// Work arrays of a step with contact.
template <class Real>
struct ContactWorkspace {
  BodyBound<Real>* bounds = nullptr;          ///< per contact body
  SpatialForce<Real>* forces = nullptr;       ///< per body of the world: sum of its contact forces
  BodyVelocityChange<Real>* kicks = nullptr;  ///< likewise
  Real* sums = nullptr;                       ///< likewise: see limited_force()
  Real* place_counts = nullptr;               ///< likewise: number of its contact points
  Vec3<Real>* bristles = nullptr;             ///< all bristles of the world
  Vec3<Real>* bent = nullptr;                 ///< the same after the substep
  MaskOf<Real>* is_bent = nullptr;            ///< per bristle: bent by a contact of this substep
  bool* is_idle = nullptr;                    ///< per bristle: zero in all lanes, untouched so far
  MaskOf<Real>* is_touched = nullptr;         ///< per body of the world: touched since begin()
  CandidatePair<Real>* near = nullptr;        ///< near pairs
  MaskOf<Real>* is_body_near = nullptr;  ///< per contact body: lanes with a near pair of this body
  ContactPoint<Real>* places =
      nullptr;  ///< contact points: kKeptPlaces, and room for one more pair
};

/// Ignores all contacts.
struct NoContactList {
  template <class... Args>
  SKYBODY_INLINE void operator()(const Args&...) const {}
};

}  // namespace skybody
