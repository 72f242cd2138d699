// One physics step of some environments of a group, side by side: the same operations in the same
// order as Mechanics and the integrators do for one, on packs.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/physics/group_stepper.h"
#include "core/physics/lane_values.h"
#include "core/physics/pack_world.h"
#include "core/physics/stepper.h"

namespace skybody {

/// Work arrays of a step, laid out in a thread's scratch memory.
template <class Real>
struct PackArrays {
  Real *q, *u, *udot, *qdot, *joint_forces, *wrench, *drive, *targets;
  StageArrays<Real> stage;
  RotorMotion<Real>* rotors[kStageTimeCount];
  RotorMotion<Real>* mean_rotors;
  BodyKinematics<Real>* motion;
  SpatialForce<Real>* forces;
  typename Forest::template Work<Real> forest;
  SweptSphere<Real>* swept;

  SKYBODY_INLINE PackArrays(const PackWorld& world, std::byte* memory) {
    lay_out(world.world, world.reach, memory);
  }
  static std::size_t bytes(const World& world, const Reach& reach) {
    PackArrays sizes;
    return sizes.lay_out(world, reach, nullptr);
  }

 private:
  PackArrays() = default;

  template <class T>
  static SKYBODY_INLINE void take(T*& array, std::byte* memory, std::size_t count,
                                  std::size_t& at) {
    static_assert(std::is_trivially_copyable_v<T>);
    array = reinterpret_cast<T*>(memory + at);
    at += count * sizeof(T);
  }

  /// @returns the bytes that it takes
  SKYBODY_INLINE std::size_t lay_out(const World& world, const Reach& reach, std::byte* memory) {
    const auto nq = static_cast<std::size_t>(world.layout.q.size);
    const auto nu = static_cast<std::size_t>(world.layout.u.size);
    const std::size_t rotor_count = world.rotors.size(), body_count = world.bodies.size();
    const bool stages = world.scenario.stepping.integrator == IntegratorChoice::kRk4;
    // Robots of one body that moves freely go in closed form.
    const bool trees =
        body_count > world.layout.robots.size() ||
        std::any_of(world.bodies.begin(), world.bodies.end(),
                    [](const WorldBody& b) { return b.model->joint.type != JointType::kFree; }) ||
        std::any_of(world.drives.begin(), world.drives.end(),
                    [](DriveKind kind) { return kind != DriveKind::kNone; });
    std::size_t at = 0;
    take(q, memory, nq, at);
    take(u, memory, nu, at);
    take(udot, memory, nu, at);
    take(qdot, memory, nq, at);
    take(joint_forces, memory, nu, at);
    take(wrench, memory, static_cast<std::size_t>(world.layout.wrench.size), at);
    take(drive, memory, static_cast<std::size_t>(world.layout.drive.size), at);
    take(targets, memory, 7 * world.drives.size(), at);
    for (auto& r : rotors) take(r, memory, rotor_count, at);
    take(mean_rotors, memory, rotor_count, at);
    take(motion, memory, body_count, at);
    take(forces, memory, body_count, at);
    if (stages) {
      take(stage.q, memory, nq, at);
      take(stage.u, memory, nu, at);
      for (int k = 0; k < 4; ++k) {
        take(stage.qdot[k], memory, nq, at);
        take(stage.udot[k], memory, nu, at);
      }
    }
    if (trees) {
      take(forest.body, memory, body_count, at);
      take(forest.ball, memory, body_count, at);
      take(forest.acceleration, memory, body_count, at);
    }
    take(swept, memory, reach.sphere_count(), at);
    return at;
  }
};

/// @tparam Real         a pack
/// @tparam Values       how parameters and what derives from them are read: LaneValues,
/// SharedValues
/// @tparam kIntegrator  the scenario's
template <class Real, class Values, IntegratorChoice kIntegrator>
class PackMechanics {
 public:
  /// @param first  of the lanes that a pack holds
  SKYBODY_INLINE PackMechanics(const PackCall& call, int first, const Values& params,
                               const Values& derived)
      : world_(*call.world),
        group_(*call.group),
        spins_(call.spins + first),
        first_(first),
        params_(params),
        derived_(derived),
        a_(*call.world, call.scratch) {}

  /// Bodies and spins from q and u.
  SKYBODY_INLINE void refresh() {
    load(group_.q, world_.world.layout.q.size, a_.q);
    load(group_.u, world_.world.layout.u.size, a_.u);
    for (const TreeBody& body : world_.forest.bodies()) make_unit(body.type, a_.q + body.q);
    update_motion(a_.q, a_.u);
    keep(group_.q, world_.world.layout.q.size, a_.q, true);
    store_motion(true);
  }

  /// One physics step of the lanes in `mask`; returns those that came through.
  SKYBODY_INLINE MaskOf<Real> advance(const MaskOf<Real>& mask) {
    const Layout& layout = world_.world.layout;
    const int nq = layout.q.size, nu = layout.u.size;
    begin_step();
    if constexpr (kIntegrator == IntegratorChoice::kRk4) {
      runge_kutta_4(*this, dt(), nq, nu, a_.q, a_.u, a_.stage);
    } else {
      semi_implicit_euler(*this, dt(), nq, nu, a_.q, a_.u, a_.qdot, a_.udot);
    }
    end_step();
    MaskOf<Real> through = mask;
    for (int i = 0; i < nq; ++i) through &= is_bounded(a_.q[i]);
    for (int i = 0; i < nu; ++i) through &= is_bounded(a_.u[i]);
    for (int i = 0; i < layout.rotor_speed.size; ++i) {
      through &= is_bounded(a_.rotors[kStepEnd][i].speed);
    }
    update_motion(a_.q, a_.u);
    if (all(through)) {  // the usual case, without reading what is overwritten
      store_step(true);
    } else {
      store_step(through);
    }
    return through;
  }

  /// Lanes where something is within reach of something else.
  SKYBODY_INLINE MaskOf<Real> is_within_reach() {
    if (world_.free_robots) {  // whose kernel keeps nothing but coordinates
      load(group_.q, world_.world.layout.q.size, a_.q);
      load(group_.u, world_.world.layout.u.size, a_.u);
      update_motion(a_.q, a_.u);
    } else {
      load_motion();
    }
    return world_.reach.is_within(a_.motion, a_.swept);
  }

  // --- what the integration rules ask for -------------------------------------------------------

  SKYBODY_INLINE void accelerations(const Real* q, const Real* u, StageTime time, Real* udot) {
    accelerations(q, u, a_.rotors[time], udot);
  }
  SKYBODY_INLINE void mean_accelerations(const Real* q, const Real* u, Real* udot) {
    accelerations(q, u, a_.mean_rotors, udot);
  }
  SKYBODY_INLINE void position_rates(const Real* q, const Real* u, Real* qdot) const {
    for (const TreeBody& body : world_.forest.bodies()) {
      skybody::position_rates(body.type, q + body.q, u + body.u, qdot + body.q);
    }
  }

 private:
  double dt() const { return world_.world.scenario.stepping.dt; }
  static SKYBODY_INLINE MaskOf<Real> is_bounded(const Real& x) { return abs(x) < kLargestState; }

  /// Value k of these lanes.
  template <class T>
  SKYBODY_INLINE T* at(T* block, int k) const {
    return block + static_cast<std::ptrdiff_t>(k) * kGroupLanes + first_;
  }
  SKYBODY_INLINE void load(const double* block, int count, Real* out) const {
    for (int k = 0; k < count; ++k) out[k] = load_lanes<Real>(at(block, k));
  }
  /// @param mask  lanes to write; or `true`: all
  static SKYBODY_INLINE void put(double* p, const Real& value, const MaskOf<Real>& mask) {
    store_lanes(p, value, mask);
  }
  static SKYBODY_INLINE void put(double* p, const Real& value, bool) { store_lanes(p, value); }
  template <class Mask>
  SKYBODY_INLINE void keep(double* block, int count, const Real* values, const Mask& mask) const {
    for (int k = 0; k < count; ++k) put(at(block, k), values[k], mask);
  }
  template <class Mask>
  SKYBODY_INLINE void store_step(const Mask& mask) {
    const Layout& layout = world_.world.layout;
    keep(group_.q, layout.q.size, a_.q, mask);
    keep(group_.u, layout.u.size, a_.u, mask);
    for (int i = 0; i < layout.rotor_speed.size; ++i) {
      put(at(group_.rotor_speed, i), a_.rotors[kStepEnd][i].speed, mask);
    }
    store_motion(mask);
  }

  /// Coordinates, commands and motion as the step finds them; how the rotors run through it.
  SKYBODY_INLINE void begin_step() {
    const Layout& layout = world_.world.layout;
    load(group_.q, layout.q.size, a_.q);
    load(group_.u, layout.u.size, a_.u);
    load(group_.wrench, layout.wrench.size, a_.wrench);
    for (int i = 0; i < layout.u.size; ++i) a_.joint_forces[i] = Real(0.0);
    for (int i = 0; i < layout.rotor_speed.size; ++i) {
      const RotorStep<Real> rotor(
          load_lag<Real>(derived_ + (world_.derived.lags + kLagSize * i)),
          load_lanes<Real>(at(group_.rotor_speed, i)),
          load_lanes<Real>(at(group_.rotor_command, i)),
          params_[layout.rotor_params[static_cast<std::size_t>(i)] + kMaxSpeed]);
      a_.rotors[kStepEnd][i] = rotor.at(kStepEnd);
      if constexpr (kIntegrator == IntegratorChoice::kSemiImplicitEuler) {
        a_.mean_rotors[i] = rotor.mean(a_.rotors[kStepEnd][i].speed, 1.0 / dt());
      } else {
        a_.rotors[kStepStart][i] = rotor.at(kStepStart);
        a_.rotors[kStepMiddle][i] = rotor.at(kStepMiddle);
      }
    }
    load_motion();
    has_motion_ = true;
    if (world_.drives.empty()) return;
    load(group_.drive, layout.drive.size, a_.drive);
    Real* target = a_.targets;
    for (const PackDrive& drive : world_.drives) {
      const TreeBody& base = world_.forest.bodies()[static_cast<std::size_t>(drive.body)];
      begin_drive(drive.kind, a_.motion[drive.body], a_.drive + drive.value, dt(), a_.q + base.q,
                  a_.u + base.u, target);
      target += 7;
    }
    has_motion_ = false;
  }

  SKYBODY_INLINE void accelerations(const Real* q, const Real* u, const RotorMotion<Real>* rotors,
                                    Real* udot) {
    if (!has_motion_) update_motion(q, u);
    has_motion_ = false;
    const ForceInputs<Real, Values> in{q, u, a_.motion, rotors, params_, a_.wrench};
    world_.forces.evaluate(in, a_.forces, a_.joint_forces);
    world_.forest.accelerations(q, u, a_.motion, derived_ + world_.derived.bodies, a_.forces,
                                a_.joint_forces, a_.forest, udot);
  }

  SKYBODY_INLINE void end_step() {
    for (const TreeBody& body : world_.forest.bodies()) {
      normalize_position(body.type, a_.q + body.q);
    }
    const Real* target = a_.targets;
    for (const PackDrive& drive : world_.drives) {
      Real* q = a_.q + world_.forest.bodies()[static_cast<std::size_t>(drive.body)].q;
      for (int k = 0; drive.kind == DriveKind::kPose && k < 7; ++k) q[k] = target[k];
      target += 7;
    }
  }

  SKYBODY_INLINE void update_motion(const Real* q, const Real* u) {
    forward_kinematics(world_.forest.bodies(), q, u, a_.motion);
  }

  /// The motion that the step before left: that of q and u.
  SKYBODY_INLINE void load_motion() {
    for (int i = 0; i < body_count(); ++i) {
      const LaneValues<Real> b(at(group_.bodies, 13 * i));
      BodyKinematics<Real>& m = a_.motion[i];
      m.position = load_vec3(b);
      m.rotation = load_quat(b + 3);
      m.axes = to_mat3(m.rotation);
      m.velocity = load_vec3(b + 7);
      m.spin = load_vec3(b + 10);
      m.angular_velocity = load_vec3(LaneValues<Real>(spins_ + 3 * i * kGroupLanes));
    }
  }

  template <class Mask>
  SKYBODY_INLINE void store_motion(const Mask& mask) {
    for (int i = 0; i < body_count(); ++i) {
      const BodyKinematics<Real>& m = a_.motion[i];
      const Real values[13] = {m.position.x, m.position.y, m.position.z, m.rotation.w, m.rotation.x,
                               m.rotation.y, m.rotation.z, m.velocity.x, m.velocity.y, m.velocity.z,
                               m.spin.x,     m.spin.y,     m.spin.z};
      for (int k = 0; k < 13; ++k) put(at(group_.bodies, 13 * i + k), values[k], mask);
      if (world_.free_robots) continue;  // whose kernel has no use for spins
      const Real spins[3] = {m.angular_velocity.x, m.angular_velocity.y, m.angular_velocity.z};
      for (int k = 0; k < 3; ++k) put(spins_ + (3 * i + k) * kGroupLanes, spins[k], mask);
    }
  }
  int body_count() const { return static_cast<int>(world_.world.bodies.size()); }

  const PackWorld& world_;
  const GroupBlocks& group_;
  double* spins_;
  int first_;
  Values params_, derived_;
  PackArrays<Real> a_;
  bool has_motion_ = false;  ///< `motion` belongs to the point that is evaluated next
};

}  // namespace skybody
