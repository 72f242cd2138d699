// The contact spheres of one body on the ground, all at once.
#pragma once

#include <vector>

#include "core/physics/bodies/kinematics.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/forces/ground_contact.h"

namespace skybody {

/// Consecutive contact spheres on one body; none touches while the origin is above `reach` [m].
struct ContactGroup {
  int body = 0, first = 0, count = 0;
  double reach = 0.0;
};

/// Those of a world, in the order of its spheres.
std::vector<ContactGroup> make_contact_groups(const World& world);

/// What the ground does to a body.
/// @param spheres    of the world
/// @param constants  its kWorldParamCount values: a pointer, or a view
/// @param body       position, axes, velocity
/// @param angular_velocity  of the body, W axes
template <class Real, class Params>
SKYBODY_INLINE SpatialForce<Real> ground_forces(const ContactGroup& group,
                                                const ContactSphere* spheres,
                                                const Params& constants,
                                                const BodyKinematics<Real>& body,
                                                const Vec3<Real>& angular_velocity) {
  SpatialForce<Real> sum = SpatialForce<Real>::zero();
  for (int i = group.first; i < group.first + group.count; ++i) {
    const ContactSphere& sphere = spheres[i];
    const Vec3<Real> center = to_real<Real>(sphere.center);
    const Real below = dot(body.axes.row(2), center) - sphere.radius;
    const auto touches = body.position.z + below < 0.0;
    if (none(touches)) continue;  // most spheres of a body that lies on the others
    const Vec3<Real> arm{dot(body.axes.row(0), center), dot(body.axes.row(1), center), below};
    const Vec3<Real> velocity = body.velocity + cross(angular_velocity, arm);
    // Where it is in the air this adds zeros, which change no sum: sums begin at +0, and so none is
    // -0.
    sum.add_force_at(arm, ground_force(constants, body.position + arm, velocity, sphere.stiffness,
                                       sphere.most_damping));
  }
  return sum;
}

}  // namespace skybody
