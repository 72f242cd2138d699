// Generalised accelerations of robots that are trees of rigid bodies, under given forces, on double
// and packs. Uses the articulated-body algorithm, and a closed form for a robot of one free body.
#pragma once

#include <vector>

#include "core/physics/bodies/body_constants.h"
#include "core/physics/forces/force_accumulators.h"
#include "core/physics/tree/articulated_body.h"
#include "core/physics/tree/ball_joint.h"

namespace skybody {

/// The trees of a world. Immutable.
class MultibodyTree {
 public:
  /// Reads the drives from `world.drives`.
  explicit MultibodyTree(const World& world);

  const std::vector<TreeBody>& bodies() const { return bodies_; }
  /// Whether a robot's base moves freely, with the frames of its joint equal to W and its own.
  bool floats(int robot) const { return tree_of(robot).floats; }

  /// Work arrays of an evaluation, one entry per body of the world.
  template <class Real>
  struct Work {
    ArticulatedBodyCache<Real>* body = nullptr;
    BallJointCache<Real>* ball = nullptr;
    SpatialAcceleration<Real>* acceleration = nullptr;
  };

  /// @param motion        of all bodies at q, u
  /// @param constants     kBodyConstantCount values per body: a pointer, or a view
  /// @param forces        per body; @param joint_forces  per u
  /// @param udot          per u, overwritten; zero for driven bases
  /// @param is_wanted     per robot: skips the others; null: skips none
  template <class Real, class Constants>
  SKYBODY_INLINE void accelerations(const Real* q, const Real* u,
                                    const BodyKinematics<Real>* motion, const Constants& constants,
                                    const SpatialForce<Real>* forces, const Real* joint_forces,
                                    const Work<Real>& work, Real* udot,
                                    const bool* is_wanted = nullptr) const {
    for (const Tree& tree : trees_) {
      if (is_wanted != nullptr && !is_wanted[tree.robot]) continue;
      if (tree.is_free_body) {
        accelerate_free_body(tree, motion, constants, forces, joint_forces, udot);
        continue;
      }
      open(tree, q, u, motion, constants, forces, work);
      gather(tree, motion, joint_forces, work);
      spread(tree, motion, joint_forces, work, udot);
    }
  }

  /// Repeats accelerations() for new forces on bodies at rest. Positions, constants and `work` must
  /// be those of that call.
  /// @param nothing  zeros: velocities and joint forces, one per u
  template <class Real, class Constants>
  SKYBODY_INLINE void accelerations_again(const BodyKinematics<Real>* at_rest,
                                          const Constants& constants,
                                          const SpatialForce<Real>* forces, const Real* nothing,
                                          const Work<Real>& work, Real* udot,
                                          const bool* is_wanted) const {
    for (const Tree& tree : trees_) {
      if (!is_wanted[tree.robot]) continue;
      if (tree.is_free_body) {
        accelerate_free_body(tree, at_rest, constants, forces, nothing, udot);
      } else {
        respond(tree, at_rest, nothing, forces, work, udot);
      }
    }
  }

  /// Prepares respond(): computes all quantities that depend on the positions of a robot's bodies
  /// and not on forces.
  /// @param robot    index; the arrays of bodies are those of the world
  /// @param at_rest  motion of all bodies, without velocities
  /// @param nothing  zeros: velocities and joint forces, one per u
  /// @param no_force  zeros: one per body
  template <class Real, class Constants>
  SKYBODY_INLINE void prepare(int robot, const Real* q, const BodyKinematics<Real>* at_rest,
                              const Constants& constants, const Real* nothing,
                              const SpatialForce<Real>* no_force, const Work<Real>& work) const {
    const Tree& tree = tree_of(robot);
    if (tree.is_free_body) return;
    open(tree, q, nothing, at_rest, constants, no_force, work);
    gather(tree, at_rest, nothing, work);
  }

  /// The accelerations that forces on the bodies of one robot cause: writes `udot`, and
  /// Work::acceleration of each body.
  template <class Real, class Constants>
  SKYBODY_INLINE void respond(int robot, const BodyKinematics<Real>* at_rest,
                              const Constants& constants, const Real* nothing,
                              const SpatialForce<Real>* forces, const Work<Real>& work,
                              Real* udot) const {
    const Tree& tree = tree_of(robot);
    if (tree.is_free_body) {
      const int i = tree.begin, u = bodies_[static_cast<std::size_t>(i)].u;
      accelerate_free_body(tree, at_rest, constants, forces, nothing, udot);
      work.acceleration[i] = {at_rest[i].axes * load_vec3(udot + (u + 3)), load_vec3(udot + u)};
      return;
    }
    respond(tree, at_rest, nothing, forces, work, udot);
  }

  /// The accelerations that forces in the joints of one robot cause.
  /// @param no_force       zeros: one per body
  /// @param joint_forces   per u
  /// @param joint_inertia  per u: added to the inertia of the bodies
  template <class Real, class Constants>
  SKYBODY_INLINE void respond_to_joints(int robot, const Real* q,
                                        const BodyKinematics<Real>* at_rest,
                                        const Constants& constants, const Real* nothing,
                                        const SpatialForce<Real>* no_force,
                                        const Real* joint_forces, const Real* joint_inertia,
                                        const Work<Real>& work, Real* udot) const {
    const Tree& tree = tree_of(robot);
    open(tree, q, nothing, at_rest, constants, no_force, work);
    gather(tree, at_rest, joint_forces, work, joint_inertia);
    spread(tree, at_rest, joint_forces, work, udot);
  }

 private:
  /// Consecutive bodies of one robot.
  struct Tree {
    int robot = 0;
    int begin = 0, end = 0;
    bool is_free_body = false;
    bool is_driven = false;  ///< the base's coordinates are prescribed, with no acceleration
    bool floats = false;  ///< the base moves freely, with its joint's frames equal to W and its own
  };

  /// Accelerates a robot of one free body; arrays as for accelerations().
  template <class Real, class Constants>
  SKYBODY_INLINE void accelerate_free_body(const Tree& tree, const BodyKinematics<Real>* motion,
                                           const Constants& constants,
                                           const SpatialForce<Real>* forces,
                                           const Real* joint_forces, Real* udot) const {
    const int i = tree.begin, u = bodies_[static_cast<std::size_t>(i)].u;
    const Constants own = constants + kBodyConstantCount * i;
    const SpatialForce<Real>&force = forces[i], none = SpatialForce<Real>::zero();
    FreeBodyForceAccumulator<Real, Constants> load(motion[i], own, {}, none.force, none);
    load.add_about_origin({force.moment, force.force + load_vec3(joint_forces + u)});
    load.add_moment(load_vec3(joint_forces + (u + 3)), Axes::kBody);
    const FreeAcceleration<Real> a = load.acceleration();
    store(a.velocity, udot + u);
    store(a.spin, udot + (u + 3));
  }

  /// Calls f with the JointColumns of a joint that is neither ball nor weld.
  template <class F>
  static SKYBODY_INLINE void with_columns(const TreeBody& body, F&& f) {
    switch (body.type) {
      case JointType::kFree:
        return f(JointColumns<6, false>());
      case JointType::kPin:
        return body.plain_body ? f(JointColumns<1, true>()) : f(JointColumns<1, false>());
      case JointType::kSlider:
        return f(JointColumns<1, false>());
      case JointType::kUniversal:
        return body.plain_body ? f(JointColumns<2, true>()) : f(JointColumns<2, false>());
      case JointType::kBall:
      case JointType::kWeld:
        return;
    }
  }
  const Tree& tree_of(int robot) const {
    std::size_t i = 0;
    while (trees_[i].robot != robot) ++i;
    return trees_[i];
  }
  static bool is_held(const Tree& tree, int i) { return tree.is_driven && i == tree.begin; }

  /// Initialises every body by itself, with its joint's columns.
  template <class Real, class Constants>
  SKYBODY_INLINE void open(const Tree& tree, const Real* q, const Real* u,
                           const BodyKinematics<Real>* motion, const Constants& constants,
                           const SpatialForce<Real>* forces, const Work<Real>& work) const {
    for (int i = tree.begin; i < tree.end; ++i) {
      const TreeBody& body = bodies_[static_cast<std::size_t>(i)];
      const BodyKinematics<Real>& b = motion[i];
      const Constants c = constants + kBodyConstantCount * i;
      ArticulatedBodyCache<Real>& w = work.body[i];
      const BodyKinematics<Real>* parent = body.parent < 0 ? nullptr : motion + body.parent;
      if (body.type == JointType::kBall) {
        open_ball(body, parent, b, w, work.ball[i]);
      } else if (i > tree.begin || !tree.floats) {
        open_joint(body, parent, frame_axes(body, motion),
                   joint_motion(body.type, q + body.q, u + body.u), b, u + body.u, w);
      }
      const Vec3<Real> com = b.axes * load_vec3(c + kBodyCom);
      w.inertia = rigid_inertia(Real(c[kBodyMass]), com,
                                rotate_inertia(b.axes, load_sym_mat3(c + kBodyInertia)));
      w.bias = velocity_force(Real(c[kBodyMass]), com, w.inertia.angular, b.angular_velocity);
      w.bias.moment -= forces[i].moment;
      w.bias.force -= forces[i].force;
    }
  }

  /// Pass from the leaves to the base: inertia and bias of each subtree, as its parent receives
  /// them.
  /// @param joint_inertia  per u: of the coordinates themselves, except of ball joints; null: none
  template <class Real>
  SKYBODY_INLINE void gather(const Tree& tree, const BodyKinematics<Real>* motion,
                             const Real* joint_forces, const Work<Real>& work,
                             const Real* joint_inertia = nullptr) const {
    for (int i = tree.end; i-- > tree.begin;) {
      if (i == tree.begin && tree.floats) continue;  // spread() solves the floating base directly
      const TreeBody& body = bodies_[static_cast<std::size_t>(i)];
      ArticulatedBodyCache<Real>& w = work.body[i];
      if (body.type == JointType::kBall) {
        SymMat3<Real> linear;
        SpatialForce<Real> bias;
        take_out_ball(body, motion[i], joint_forces + body.u, w, work.ball[i], linear, bias);
        if (body.parent >= 0)
          load_parent(carried(linear, w.arm), bias, w.arm, work.body[body.parent]);
        continue;
      }
      ArticulatedInertia<Real> inertia = w.inertia;
      SpatialForce<Real> bias = w.bias;
      if (!is_held(tree, i) && body.type != JointType::kWeld) {
        with_columns(body, [&](auto columns) SKYBODY_INLINE_LAMBDA {
          using Columns = decltype(columns);
          eliminate<Columns>(joint_inertia == nullptr ? nullptr : joint_inertia + body.u, w);
          leave_residual<Columns>(joint_forces + body.u, w);
          if (body.parent >= 0) reduce<Columns>(w, inertia, bias);
        });
      } else {
        const SpatialForce<Real> drifting = inertia * w.drift;
        bias.moment += drifting.moment;
        bias.force += drifting.force;
      }
      if (body.parent >= 0)
        load_parent(shifted(inertia, w.arm), bias, w.arm, work.body[body.parent]);
    }
  }

  /// Responds to forces on a robot other than one free body.
  template <class Real>
  SKYBODY_INLINE void respond(const Tree& tree, const BodyKinematics<Real>* at_rest,
                              const Real* nothing, const SpatialForce<Real>* forces,
                              const Work<Real>& work, Real* udot) const {
    for (int i = tree.begin; i < tree.end; ++i) {
      work.body[i].bias = {-forces[i].moment, -forces[i].force};
    }
    regather(tree, at_rest, nothing, work);
    spread(tree, at_rest, nothing, work, udot);
  }

  /// gather() for other forces on bodies at rest.
  template <class Real>
  SKYBODY_INLINE void regather(const Tree& tree, const BodyKinematics<Real>* at_rest,
                               const Real* nothing, const Work<Real>& work) const {
    for (int i = tree.end; i-- > tree.begin;) {
      if (i == tree.begin && tree.floats) continue;
      const TreeBody& body = bodies_[static_cast<std::size_t>(i)];
      ArticulatedBodyCache<Real>& w = work.body[i];
      SpatialForce<Real> bias = w.bias;
      if (body.type == JointType::kBall) {
        SymMat3<Real> linear;
        take_out_ball(body, at_rest[i], nothing, w, work.ball[i], linear, bias);
      } else if (!is_held(tree, i) && body.type != JointType::kWeld) {
        with_columns(body, [&](auto columns) SKYBODY_INLINE_LAMBDA {
          using Columns = decltype(columns);
          leave_residual<Columns>(nothing, w);
          pass_on<Columns>(w, bias);
        });
      }
      if (body.parent >= 0) add_to_parent(bias, w.arm, work.body[body.parent]);
    }
  }

  template <class Real>
  static SKYBODY_INLINE void add_to_parent(const SpatialForce<Real>& bias, const Vec3<Real>& arm,
                                           ArticulatedBodyCache<Real>& parent) {
    const SpatialForce<Real> there = shifted(bias, arm);
    parent.bias.moment += there.moment;
    parent.bias.force += there.force;
  }

  /// @param inertia  about the parent's O; @param bias  about the point that is `arm` from it
  template <class Real>
  static SKYBODY_INLINE void load_parent(const ArticulatedInertia<Real>& inertia,
                                         const SpatialForce<Real>& bias, const Vec3<Real>& arm,
                                         ArticulatedBodyCache<Real>& parent) {
    parent.inertia = {parent.inertia.angular + inertia.angular,
                      parent.inertia.coupling + inertia.coupling,
                      parent.inertia.linear + inertia.linear};
    add_to_parent(bias, arm, parent);
  }

  /// Pass from the base to the leaves: the acceleration of each body from its parent's.
  template <class Real>
  SKYBODY_INLINE void spread(const Tree& tree, const BodyKinematics<Real>* motion,
                             const Real* joint_forces, const Work<Real>& work, Real* udot) const {
    int first = tree.begin;
    if (tree.floats) {
      const int u = bodies_[static_cast<std::size_t>(first)].u;
      const Mat3<Real>& axes = motion[first].axes;
      const SpatialForce<Real>& bias = work.body[first].bias;
      SpatialAcceleration<Real>& a = work.acceleration[first];
      a = free_acceleration(work.body[first].inertia,
                            {axes * load_vec3(joint_forces + u + 3) - bias.moment,
                             load_vec3(joint_forces + u) - bias.force});
      store(a.linear, udot + u);
      store(transpose_times(axes, a.angular), udot + u + 3);
      ++first;
    }
    for (int i = first; i < tree.end; ++i) {
      const TreeBody& body = bodies_[static_cast<std::size_t>(i)];
      ArticulatedBodyCache<Real>& w = work.body[i];
      SpatialAcceleration<Real>& a = work.acceleration[i];
      a = w.drift;
      if (body.parent >= 0) {
        const SpatialAcceleration<Real>& parent = work.acceleration[body.parent];
        a.angular += parent.angular;
        a.linear += parent.linear + cross(parent.angular, w.arm);
      }
      if (is_held(tree, i)) {
        for (int k = 0; k < velocity_size(body.type); ++k) udot[body.u + k] = Real(0.0);
        continue;
      }
      if (body.type == JointType::kBall) {
        follow_ball(body, motion[i], work.ball[i], a, udot + body.u);
        continue;
      }
      with_columns(body, [&](auto columns) SKYBODY_INLINE_LAMBDA {
        substitute<decltype(columns)>(w, a, udot + body.u);
      });
    }
  }

  std::vector<TreeBody> bodies_;
  std::vector<Tree> trees_;
};

}  // namespace skybody
