// Joint stops, applied as a correction at the end of a physics step of any integrator. A stop is a
// spring and a damper beyond a limit, integrated by implicit Euler. With g the penetration of the
// limits at the end of the step without stops, v its rate there, and M the inertia of all
// coordinates, the velocities change by
//   (M + dt C + dt^2 K) du = -dt (K g + C v)     where K g + C v > 0: a stop never pulls
// and the coordinates by dt du. At a given configuration the energy of motion and springs therefore
// falls by at least dt v' C v', with v' the remaining rate, for every dt, stiffness and damping:
// the forces are gradients of a convex energy at the end of the step. The matrix added to M is
// diagonal. It is added to the pivots of the articulated-body algorithm, which then solves for all
// stops of a robot at once.
#pragma once

#include <vector>

#include "core/physics/forces/joint_force.h"
#include "core/physics/tree/multibody_tree.h"

namespace skybody {

/// Work arrays of stops, one entry per u, or per body, of the world.
template <class Real>
struct JointStopWorkspace {
  Real* force = nullptr;    ///< -(K g + C v)
  Real* inertia = nullptr;  ///< dt C + dt^2 K
  Real* change = nullptr;   ///< du / dt
  Real* nothing = nullptr;
  SpatialForce<Real>* no_forces = nullptr;
  BodyKinematics<Real>* at_rest = nullptr;
};

/// The stops of a world's joints. Immutable; refers to the world, which must outlive it.
class JointStops {
 public:
  explicit JointStops(const World& world);

  bool any() const { return !robots_.empty(); }

  /// Calls f(robot, where, change) for robots with a joint at a stop in any lane of `mask`: `where`
  /// is the lanes, `change` the acceleration of its coordinates by the stops' forces, one per u of
  /// the world.
  /// @param multibody  the trees of the world
  /// @param constants  kBodyConstantCount values per body: a pointer, or a view
  /// @param q          the coordinates at which the inertias are computed
  /// @param end_q, end_u  at the end of the step without stops; only those of joints with stops are
  ///                   read
  template <class Real, class Params, class Constants, class F>
  SKYBODY_INLINE void act(const MultibodyTree& multibody, const Params& params,
                          const Constants& constants, double dt, const MaskOf<Real>& mask,
                          const Real* q, const Real* end_q, const Real* end_u,
                          const typename MultibodyTree::template Work<Real>& tree,
                          const JointStopWorkspace<Real>& work, const F& f) const {
    for (const Robot& robot : robots_) {
      const RobotLayout& layout = world_.layout.robots[static_cast<std::size_t>(robot.index)];
      begin(layout, work);
      MaskOf<Real> is_at_stop(false);
      for (const int i : robot.bodies) {
        is_at_stop |= push(i, params, dt, end_q, end_u, work);
      }
      const auto where = logical_and(mask, is_at_stop);
      if (none(where)) continue;
      const int last = layout.first_body + layout.body_count;
      forward_kinematics(multibody.bodies(), layout.first_body, last, q, work.nothing,
                         work.at_rest);
      multibody.respond_to_joints(robot.index, q, work.at_rest, constants, work.nothing,
                                  work.no_forces, work.force, work.inertia, tree, work.change);
      f(layout, where, work.change);
    }
  }

 private:
  struct Robot {
    int index;
    std::vector<int> bodies;  ///< bodies whose joints have stops
  };

  template <class Real>
  SKYBODY_INLINE void begin(const RobotLayout& robot, const JointStopWorkspace<Real>& work) const {
    const Real zero(0.0);
    for (int k = robot.first_u; k < robot.first_u + robot.u_count; ++k) {
      work.force[k] = work.inertia[k] = work.nothing[k] = zero;
    }
    for (int i = robot.first_body; i < robot.first_body + robot.body_count; ++i) {
      work.no_forces[i] = SpatialForce<Real>::zero();
    }
  }

  /// Sets the force and inertia of the joint of body i. @returns the lanes at a stop
  template <class Real, class Params>
  SKYBODY_INLINE MaskOf<Real> push(int i, const Params& params, double dt, const Real* q,
                                   const Real* u, const JointStopWorkspace<Real>& work) const {
    const auto index = static_cast<std::size_t>(i);
    const WorldBody& body = world_.bodies[index];
    const auto constants = params + world_.layout.joint_params[index];
    const Real force = limit_force(body.model->joint.limit, constants, q[body.q], u[body.u]);
    const Real inertia = dt * constants[kLimitDamping] + (dt * dt) * constants[kLimitStiffness];
    const auto is_at_stop = abs(force) > 0.0;
    work.force[body.u] = force;
    work.inertia[body.u] = select(is_at_stop, inertia, Real(0.0));
    return is_at_stop;
  }

  const World& world_;
  std::vector<Robot> robots_;  ///< robots with stops
};

}  // namespace skybody
