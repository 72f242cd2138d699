#include "core/physics/bodies/joint_reactions.h"

#include "core/physics/bodies/body_constants.h"

namespace skybody {
namespace {

/// The force on a body that causes given accelerations: the rates of its momentum and of its
/// angular momentum about its origin, W axes.
SpatialForce<double> momentum_rate(const double* constants, const BodyKinematics<double>& body,
                                   const BodyAcceleration& a) {
  const Vec3<double> w = body.spin, com = load_vec3(constants + kCom);
  const Vec3<double> com_in_body = cross(a.angular, com) + cross(w, cross(w, com));
  const Vec3<double> force = constants[kMass] * (a.linear + body.axes * com_in_body);
  const SymMat3<double> inertia = load_sym_mat3(constants + kInertia);
  const Vec3<double> about_com = inertia * a.angular + cross(w, inertia * w);
  return {body.axes * about_com + cross(body.axes * com, force), force};
}

}  // namespace

void joint_reactions(const World& world, const double* params, const BodyKinematics<double>* motion,
                     const BodyAcceleration* accelerations, const SpatialForce<double>* loads,
                     SpatialForce<double>* out) {
  const auto bodies = static_cast<int>(world.bodies.size());
  for (int i = 0; i < bodies; ++i) {
    const double* constants = params + world.layout.body_params[static_cast<std::size_t>(i)];
    out[i] = momentum_rate(constants, motion[i], accelerations[i]);
    out[i].force -= loads[i].force;
    out[i].moment -= loads[i].moment;
  }
  for (int i = bodies - 1; i >= 0; --i) {  // parents come before their children
    const int parent = world.bodies[static_cast<std::size_t>(i)].parent;
    if (parent < 0) continue;
    out[parent].moment += out[i].moment;
    out[parent].add_force_at(motion[i].position - motion[parent].position, out[i].force);
  }
}

}  // namespace skybody
