// Every force of ours on the bodies of a world: gravity, rotors, disturbances, wrenches of
// controllers, ground contact, joints. Evaluated inside the derivative, one code for all dynamics,
// for double and packs.
#pragma once

#include <vector>

#include "core/physics/contact_group.h"
#include "core/physics/joint_force.h"
#include "core/physics/kinematics.h"
#include "core/physics/rotor_force.h"
#include "core/physics/spatial_force.h"
#include "core/physics/world.h"

namespace skybody {

/// What forces depend on at one instant. Pointers to the values of one environment (or one pack),
/// in the order of the layout's blocks.
/// @tparam Params  how parameters are read: a pointer, or a view (lane_values.h)
template <class Real, class Params = const Real*>
struct ForceInputs {
  const Real* q = nullptr;
  const Real* u = nullptr;
  const BodyKinematics<Real>* bodies = nullptr;
  const RotorMotion<Real>* rotors = nullptr;
  Params params;
  const Real* wrench = nullptr;
};

/// A rotor of a world on its body; every one; and the groups that they form.
RotorPlace make_rotor_place(const World& world, std::size_t index);
std::vector<RotorPlace> make_rotor_places(const World& world);
std::vector<RotorGroup> make_rotor_groups(const World& world);

/// Bodies whose joint has damping, a spring or limits.
std::vector<int> joints_with_forces(const World& world);

/// Immutable; refers to the world, which must outlive it.
class ForceModel {
 public:
  explicit ForceModel(const World& world);

  /// @param forces        one per body, overwritten
  /// @param joint_forces  one per u; only those of joints with damping, springs or limits are
  ///                      written, the others must be zero
  template <class Real, class Params>
  SKYBODY_INLINE void evaluate(const ForceInputs<Real, Params>& in, SpatialForce<Real>* forces,
                               Real* joint_forces) const {
    add_gravity(in, forces);
    add_rotors(in, forces);
    add_disturbances(in, forces);
    add_wrenches(in, forces);
    add_ground(in, forces);
    add_joints(in, joint_forces);
  }

 private:
  template <class Real, class Params>
  static SKYBODY_INLINE Vec3<Real> com_arm(const BodyKinematics<Real>& body,
                                           const Params& body_params) {
    return body.axes * load_vec3(body_params + kCom);
  }

  /// Overwrites: the first to be called.
  template <class Real, class Params>
  SKYBODY_INLINE void add_gravity(const ForceInputs<Real, Params>& in,
                                  SpatialForce<Real>* forces) const {
    const Vec3<Real> gravity = to_real<Real>(world_.scenario.gravity);
    for (std::size_t i = 0; i < world_.bodies.size(); ++i) {
      const auto params = in.params + world_.layout.body_params[i];
      forces[i].force = gravity * params[kMass];
      forces[i].moment = cross(com_arm(in.bodies[i], params), forces[i].force);
    }
  }

  template <class Real, class Params>
  SKYBODY_INLINE void add_rotors(const ForceInputs<Real, Params>& in,
                                 SpatialForce<Real>* forces) const {
    for (const RotorGroup& group : rotor_groups_) {
      const BodyKinematics<Real>& body = in.bodies[group.body];
      const Vec3<Real> velocity = transpose_times(body.axes, body.velocity);
      const SpatialForce<Real> sum = rotor_forces(
          group, rotors_.data(), in.params,
          [&](int i) SKYBODY_INLINE_LAMBDA { return in.rotors[i]; }, velocity, body.spin);
      forces[group.body].force += body.axes * sum.force;
      forces[group.body].moment += body.axes * sum.moment;
    }
  }

  /// Paper eq. 1: F_W at the base's centre of mass in W axes, M_B in base axes.
  template <class Real, class Params>
  SKYBODY_INLINE void add_disturbances(const ForceInputs<Real, Params>& in,
                                       SpatialForce<Real>* forces) const {
    for (std::size_t r = 0; r < bases_.size(); ++r) {
      const int base = bases_[r];
      const auto params = in.params + world_.layout.disturbance_params[r];
      const Vec3<Real> force = load_vec3(params + kDisturbanceForce);
      const Vec3<Real> moment = load_vec3(params + kDisturbanceMoment);
      const auto disturbed = logical_or(is_not_zero(force), is_not_zero(moment));
      if (none(disturbed)) continue;
      const Vec3<Real> arm = com_arm(in.bodies[base], in.params + world_.layout.body_params[base]);
      SpatialForce<Real> sum = forces[base];
      sum.add_force_at(arm, force);
      sum.moment += in.bodies[base].axes * moment;
      // Lanes without keep their sums untouched, as if alone: adding +0 would turn a -0 round.
      forces[base].force = select(disturbed, sum.force, forces[base].force);
      forces[base].moment = select(disturbed, sum.moment, forces[base].moment);
    }
  }

  template <class Real, class Params>
  SKYBODY_INLINE void add_wrenches(const ForceInputs<Real, Params>& in,
                                   SpatialForce<Real>* forces) const {
    for (std::size_t s = 0; s < world_.sites.size(); ++s) {
      const WrenchSite& site = world_.sites[s];
      const BodyKinematics<Real>& body = in.bodies[site.body];
      Vec3<Real> force = load_vec3(in.wrench + 6 * s);
      Vec3<Real> moment = load_vec3(in.wrench + 6 * s + 3);
      if (!site.world_axes) {
        force = body.axes * force;
        moment = body.axes * moment;
      }
      const Vec3<Real> arm = site.at_com
                                 ? com_arm(body, in.params + world_.layout.body_params[site.body])
                                 : body.axes * to_real<Real>(site.point);
      forces[site.body].add_force_at(arm, force);
      forces[site.body].moment += moment;
    }
  }

  template <class Real, class Params>
  SKYBODY_INLINE void add_ground(const ForceInputs<Real, Params>& in,
                                 SpatialForce<Real>* forces) const {
    const ContactSettings& contact = world_.scenario.contact;
    for (const ContactGroup& group : contact_groups_) {
      const BodyKinematics<Real>& body = in.bodies[group.body];
      const auto near_ground = body.position.z < group.reach;
      if (none(near_ground)) continue;
      const SpatialForce<Real> sum = ground_forces(group, world_.spheres.data(), contact, body);
      // Lanes in the air keep their sums untouched: adding +0 would turn a -0 round.
      SpatialForce<Real>& total = forces[group.body];
      total.force = select(near_ground, total.force + sum.force, total.force);
      total.moment = select(near_ground, total.moment + sum.moment, total.moment);
    }
  }

  template <class Real, class Params>
  SKYBODY_INLINE void add_joints(const ForceInputs<Real, Params>& in, Real* joint_forces) const {
    for (const int i : stiff_joints_) {
      const WorldBody& body = world_.bodies[i];
      joint_force(body.model->joint, in.q + body.q, in.u + body.u, joint_forces + body.u);
    }
  }

  const World& world_;
  std::vector<RotorPlace> rotors_;
  std::vector<RotorGroup> rotor_groups_;
  std::vector<ContactGroup> contact_groups_;
  std::vector<int> bases_;         ///< per robot: world body index of its base
  std::vector<int> stiff_joints_;  ///< bodies whose joint has damping, a spring or limits
};

}  // namespace skybody
