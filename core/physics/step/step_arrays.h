// Work arrays of a step, in a thread's scratch memory, and coordinates.
#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

#include "core/physics/coupling/couplings.h"
#include "core/physics/step/group_stepper.h"
#include "core/physics/step/high_spin_robots.h"
#include "core/physics/step/step_plan.h"

namespace skybody {

/// Allocates arrays in a block of memory, one after another.
struct StepArena {
  std::byte* memory;
  std::size_t used = 0;

  template <class T>
  SKYBODY_INLINE void take(T*& array, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    used = (used + alignof(T) - 1) / alignof(T) * alignof(T);
    array = reinterpret_cast<T*>(memory + used);
    used += count * sizeof(T);
  }
};

/// Coordinates q and u of a world, one after another, for the integration rules; or their rates.
template <class Real>
struct Coordinates {
  const std::vector<TreeBody>* tree = nullptr;
  Real *q = nullptr, *u = nullptr;  ///< u follows q
  int q_count = 0, u_count = 0;

  /// start + time rate, element by element.
  SKYBODY_INLINE void set(const Coordinates& start, const Coordinates& rate, double time) {
    for (int i = 0; i < q_count + u_count; ++i) q[i] = start.q[i] + time * rate.q[i];
  }
  SKYBODY_INLINE void add(const Coordinates& rate) {
    for (int i = 0; i < q_count + u_count; ++i) q[i] += rate.q[i];
  }
  template <class Time>
  SKYBODY_INLINE void change_velocity(const Coordinates& rate, const Time& time) {
    for (int i = 0; i < u_count; ++i) u[i] += time * rate.u[i];
  }
  template <class Time>
  SKYBODY_INLINE void drift(const Time& time) {
    for (const TreeBody& body : *tree) {
      drift_position(body.type, time, u + body.u, q + body.q);
      normalize_position(body.type, q + body.q);
    }
  }
  SKYBODY_INLINE void copy(const Coordinates& from) const {
    for (int i = 0; i < q_count + u_count; ++i) q[i] = from.q[i];
  }
  /// Copies `other` in the lanes outside a mask.
  SKYBODY_INLINE void keep(const MaskOf<Real>& mask, const Coordinates& other) const {
    for (int i = 0; i < q_count + u_count; ++i) q[i] = select(mask, q[i], other.q[i]);
  }
  SKYBODY_INLINE void take_from(StepArena& arena, const StepPlan& plan) {
    tree = &plan.multibody.bodies();
    q_count = plan.world.layout.q.size;
    u_count = plan.world.layout.u.size;
    arena.take(q, static_cast<std::size_t>(q_count + u_count));
    u = q + q_count;
  }
  template <class Time>
  SKYBODY_INLINE void kick(const Coordinates& start, const Coordinates& rate, const Time& time) {
    for (int i = 0; i < q_count; ++i) q[i] = start.q[i];
    for (int i = 0; i < u_count; ++i) u[i] = start.u[i] + time * rate.u[i];
  }
  SKYBODY_INLINE void change_position(double time) {
    for (const TreeBody& body : *tree) {
      Real rates[7];
      position_rates(body.type, q + body.q, u + body.u, rates);
      for (int i = 0; i < position_size(body.type); ++i) q[body.q + i] += time * rates[i];
    }
  }
};

/// Work arrays of a step, laid out in a thread's scratch memory.
template <class Real>
struct StepArrays {
  Coordinates<Real> now;
  StageRates<Coordinates<Real>> stages;
  Real *joint_forces, *wrench, *drive, *targets;
  RotorMotion<Real>* rotors[kStageTimeCount];
  Real* joint_targets[kStageTimeCount];
  BodyKinematics<Real>* motion;
  SpatialForce<Real>* forces;
  typename MultibodyTree::template Work<Real> multibody;
  CouplingWorkspace<Real> couplings;
  JointStopWorkspace<Real> stops;
  HighSpinRobot<Real>* fast;  ///< per robot
  Real* fast_bodies;          ///< kBodyConstantCount per body, of fast robots

  SKYBODY_INLINE StepArrays(const StepPlan& plan, std::byte* memory) { lay_out(plan, memory); }
  static std::size_t bytes(const StepPlan& plan) {
    StepArrays sizes;
    return sizes.lay_out(plan, nullptr);
  }

 private:
  StepArrays() = default;

  /// @returns the number of bytes used
  SKYBODY_INLINE std::size_t lay_out(const StepPlan& plan, std::byte* memory) {
    const StateLayout& layout = plan.world.layout;
    const std::size_t bodies = plan.world.bodies.size();
    StepArena arena{memory};
    for (Coordinates<Real>* c : {&now, &stages.point, &stages.outer, &stages.inner, &stages.rate}) {
      c->take_from(arena, plan);
    }
    arena.take(joint_forces, static_cast<std::size_t>(layout.u.size));
    arena.take(wrench, static_cast<std::size_t>(layout.wrench.size));
    arena.take(drive, static_cast<std::size_t>(layout.drive.size));
    arena.take(targets, 7 * plan.drives.size());
    for (auto& r : rotors) arena.take(r, plan.world.rotors.size());
    for (auto& t : joint_targets) arena.take(t, plan.world.joint_drives.size());
    arena.take(motion, bodies);
    arena.take(forces, bodies);
    arena.take(multibody.body, bodies);
    arena.take(multibody.ball, bodies);
    arena.take(multibody.acceleration, bodies);
    couplings.take_from(arena, plan.couplings);
    arena.take(fast, layout.robots.size());
    arena.take(fast_bodies, kBodyConstantCount * bodies);
    if (!plan.stops.any()) return arena.used;
    for (Real** values : {&stops.force, &stops.inertia, &stops.change, &stops.nothing}) {
      arena.take(*values, static_cast<std::size_t>(layout.u.size));
    }
    arena.take(stops.no_forces, bodies);
    arena.take(stops.at_rest, bodies);
    return arena.used;
  }
};

/// Writes the motion of the bodies [first, last) to GroupBlocks::bodies and StepCall::spins.
/// @param lanes  a LaneSlice or LaneList
/// @param mask   lanes to write, or AllLanes
template <class Real, class Lanes, class Mask>
SKYBODY_INLINE void store_motion(int first, int last, const BodyKinematics<Real>* motion,
                                 const Lanes& lanes, const Mask& mask, double* bodies,
                                 double* spins) {
  for (int i = first; i < last; ++i) {
    const BodyKinematics<Real>& m = motion[i];
    const Real values[13] = {m.position.x, m.position.y, m.position.z, m.rotation.w, m.rotation.x,
                             m.rotation.y, m.rotation.z, m.velocity.x, m.velocity.y, m.velocity.z,
                             m.spin.x,     m.spin.y,     m.spin.z};
    lanes.store(values, 13, mask, lanes.block(bodies, 13 * i));
    if (spins == nullptr) continue;
    const Vec3<Real>& w = m.angular_velocity;
    const Real of_body[3] = {w.x, w.y, w.z};
    lanes.store(of_body, 3, mask, lanes.block(spins, 3 * i));
  }
}

/// Reads what store_motion() has written for the bodies [0, count).
/// @param lanes  a LaneSlice
template <class Real, class Lanes>
SKYBODY_INLINE void load_motion(int count, const Lanes& lanes, double* bodies, double* spins,
                                BodyKinematics<Real>* motion) {
  for (int i = 0; i < count; ++i) {
    const LaneValues<Real> b(lanes.at(bodies, 13 * i));
    BodyKinematics<Real>& m = motion[i];
    m.position = load_vec3(b);
    m.rotation = load_quat(b + 3);
    m.axes = to_mat3(m.rotation);
    m.velocity = load_vec3(b + 7);
    m.spin = load_vec3(b + 10);
    m.angular_velocity = load_vec3(LaneValues<Real>(lanes.at(spins, 3 * i)));
  }
}

}  // namespace skybody
