// All forces of the model on the bodies of a world: gravity, rotors, disturbances, wrenches of
// controllers and effects, joints. Contact is separate (core/physics/contact). Evaluated inside the
// derivative. The same code serves all dynamics, double and packs.
#pragma once

#include <vector>

#include "core/physics/bodies/kinematics.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/forces/force_terms.h"
#include "core/physics/forces/joint_drive.h"
#include "core/physics/forces/joint_force.h"
#include "core/physics/forces/rotor_force.h"
#include "core/physics/world/world.h"

namespace skybody {

/// The arguments of the forces at one instant: pointers to the values of one environment (or one
/// pack), in the order of the layout's blocks.
/// @tparam Params  access to parameters: a pointer, or a view (lane_values.h)
template <class Real, class Params = const Real*>
struct ForceInputs {
  const Real* q = nullptr;
  const Real* u = nullptr;
  const BodyKinematics<Real>* bodies = nullptr;
  const RotorMotion<Real>* rotors = nullptr;
  Params params;
  const Real* wrench = nullptr;
  const Real* joint_targets = nullptr;    ///< per joint drive: its target at this instant
  const HeldLanes<Real>* held = nullptr;  ///< null: no effects
};

/// One rotor's mounting on its body, those of all rotors, and the groups of rotors on one body.
RotorMount make_rotor_place(const World& world, std::size_t index);
std::vector<RotorMount> make_rotor_places(const World& world);
std::vector<RotorGroup> make_rotor_groups(const World& world);

/// Immutable; refers to the world, which must outlive it.
class ForceModel {
 public:
  explicit ForceModel(const World& world);

  /// @param forces        one per body, overwritten
  /// @param joint_forces  one per u; only those of joints that have constants are written, the
  ///                      others must be zero
  template <class Real, class Params>
  SKYBODY_INLINE void evaluate(const ForceInputs<Real, Params>& in, SpatialForce<Real>* forces,
                               Real* joint_forces) const {
    add_gravity(in, forces);
    add_rotors(in, forces);
    add_disturbances(in, forces);
    add_wrenches(in, forces);
    add_held(in, forces);
    add_joints(in, joint_forces);
  }

  const std::vector<JointDriveStep>& joint_drives() const { return joint_drives_; }

 private:
  /// Sum of the forces on body i.
  template <class Real, class Params>
  SKYBODY_INLINE OriginForceAccumulator<Real, Params> load(const ForceInputs<Real, Params>& in,
                                                           int i,
                                                           SpatialForce<Real>* forces) const {
    return {in.bodies[i], in.params + world_.layout.body_params[static_cast<std::size_t>(i)],
            forces[i]};
  }

  /// Overwrites the sums: must be called first.
  template <class Real, class Params>
  SKYBODY_INLINE void add_gravity(const ForceInputs<Real, Params>& in,
                                  SpatialForce<Real>* forces) const {
    const Vec3<Real> gravity = load_vec3(in.params + (world_.layout.world_params + kGravity));
    const int count = static_cast<int>(world_.bodies.size());
    for (int i = 0; i < count; ++i) load(in, i, forces).begin(gravity);
  }

  template <class Real, class Params>
  SKYBODY_INLINE void add_rotors(const ForceInputs<Real, Params>& in,
                                 SpatialForce<Real>* forces) const {
    for (const RotorGroup& group : rotor_groups_) {
      const BodyKinematics<Real>& body = in.bodies[group.body];
      const Vec3<Real> velocity = air_velocity(in.held, group.body, body);
      const auto motion = [&](int i) SKYBODY_INLINE_LAMBDA { return in.rotors[i]; };
      load(in, group.body, forces)
          .add_in_body(held_rotor_forces<Real>(group, rotors_.data(), in.params, in.held, motion,
                                               1.0, velocity, body.spin));
    }
  }

  template <class Real, class Params>
  SKYBODY_INLINE void add_held(const ForceInputs<Real, Params>& in,
                               SpatialForce<Real>* forces) const {
    if (in.held == nullptr) return;
    for (int i = 0; i < static_cast<int>(world_.bodies.size()); ++i) {
      auto sum = load(in, i, forces);
      add_held_forces(*in.held, i, in.bodies[i], sum);
    }
  }

  template <class Real, class Params>
  SKYBODY_INLINE void add_disturbances(const ForceInputs<Real, Params>& in,
                                       SpatialForce<Real>* forces) const {
    for (std::size_t r = 0; r < bases_.size(); ++r) {
      auto sum = load(in, bases_[r], forces);
      add_disturbance<Real>(in.params + world_.layout.robot_params[r], sum);
    }
  }

  template <class Real, class Params>
  SKYBODY_INLINE void add_wrenches(const ForceInputs<Real, Params>& in,
                                   SpatialForce<Real>* forces) const {
    const Real* wrench = in.wrench;
    for (const WrenchSite& site : world_.sites) {
      auto sum = load(in, site.body, forces);
      add_wrench<Real>(site, wrench, sum);
      wrench += 6;
    }
  }

  template <class Real, class Params>
  SKYBODY_INLINE void add_joints(const ForceInputs<Real, Params>& in, Real* joint_forces) const {
    for (const int i : joints_) {
      const WorldBody& body = world_.bodies[i];
      joint_force(body.model->joint, in.params + world_.layout.joint_params[i], in.q + body.q,
                  in.u + body.u, joint_forces + body.u);
    }
    const Real* target = in.joint_targets;
    for (const JointDriveStep& d : joint_drives_) {
      joint_forces[d.u] += drive_force(d.drive, *target++, in.q[d.q], in.u[d.u]);
    }
  }

  const World& world_;
  std::vector<RotorMount> rotors_;
  std::vector<RotorGroup> rotor_groups_;
  std::vector<int> bases_;   ///< per robot: world body index of its base
  std::vector<int> joints_;  ///< bodies whose joint has constants
  std::vector<JointDriveStep> joint_drives_;
};

}  // namespace skybody
