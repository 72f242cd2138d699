// FreeRobotStep on packs: from the values of a group to its values.
#pragma once

#include "core/physics/free_robot_step.h"
#include "core/physics/pack_call.h"

namespace skybody {

/// What a call says, by value: what is stored through pointers cannot have changed it.
struct FreeCall {
  SKYBODY_INLINE explicit FreeCall(const PackCall& call)
      : robots(*call.world->free_robots),
        group(*call.group),
        derived(call.world->derived),
        robot_count(robots.robots.size()),
        bodies_are_coordinates(group.bodies == group.q),
        scratch(call.scratch) {}

  const FreeRobots& robots;
  GroupBlocks group;
  DerivedLayout derived;
  std::size_t robot_count;
  bool bodies_are_coordinates;
  std::byte* scratch;
};

/// A physics step of all robots of the lanes in one pack.
template <class Real, class Values, IntegratorChoice kIntegrator>
class FreePack {
 public:
  SKYBODY_INLINE FreePack(const FreeCall& call, int first, const Values& params,
                          const Values& derived)
      : call_(call),
        first_(first),
        in_{LaneValues<Real>(call.group.rotor_speed + first),
            LaneValues<Real>(call.group.rotor_command + first),
            LaneValues<Real>(call.group.wrench + first),
            params,
            derived + call.derived.lags,
            derived + call.derived.factors,
            derived + call.derived.bodies},
        motions_(reinterpret_cast<FreeMotion<Real>*>(call.scratch)),
        end_speeds_(reinterpret_cast<Real*>(motions_ + call.robot_count)) {}

  /// @returns those of `lanes` that came through; the others are as they were
  SKYBODY_INLINE std::uint32_t advance(std::uint32_t lanes) {
    const std::vector<FreeRobot>& robots = call_.robots.robots;
    if (call_.robot_count > 1) return advance_all(lanes);
    if (!robots[0].has_four_level_rotors()) return advance_one<0>(robots[0], end_speeds_, lanes);
    Real end_speeds[4];
    return advance_one<4>(robots[0], end_speeds, lanes);
  }

 private:
  static constexpr std::uint32_t kAll = (1u << kLanesOf<Real>)-1u;

  template <class T>
  SKYBODY_INLINE T* at(T* block, int k) const {
    return block + static_cast<std::ptrdiff_t>(k) * kGroupLanes + first_;
  }

  /// The only robot of its world.
  template <int kLevelRotors>
  SKYBODY_INLINE std::uint32_t advance_one(const FreeRobot& robot, Real* end_speeds,
                                           std::uint32_t lanes) const {
    FreeMotion<Real> motion;
    const MaskOf<Real> sound = advance<kLevelRotors>(robot, motion, end_speeds);
    if (lanes == kAll && all(sound)) {  // the usual case, without a mask
      write<kLevelRotors>(robot, motion, end_speeds, true);
      return lanes;
    }
    const MaskOf<Real> through = sound & mask_from_bits<Real>(lanes);
    write<kLevelRotors>(robot, motion, end_speeds, through);
    return bits_from_mask(through);
  }

  /// Nothing is written before it is known which lanes came through with all their robots.
  SKYBODY_INLINE std::uint32_t advance_all(std::uint32_t lanes) const {
    MaskOf<Real> through = mask_from_bits<Real>(lanes);
    std::size_t r = 0;
    for (const FreeRobot& robot : call_.robots.robots) {
      FreeMotion<Real> motion;
      Real* end_speeds = end_speeds_ + robot.rotors.first;
      through &= robot.has_four_level_rotors() ? advance<4>(robot, motion, end_speeds)
                                               : advance<0>(robot, motion, end_speeds);
      motions_[r++] = motion;
    }
    r = 0;
    const bool came_all = all(through);
    for (const FreeRobot& robot : call_.robots.robots) {
      const FreeMotion<Real>& motion = motions_[r++];
      const Real* end_speeds = end_speeds_ + robot.rotors.first;
      if (came_all) {
        write<0>(robot, motion, end_speeds, true);
      } else {
        write<0>(robot, motion, end_speeds, through);
      }
    }
    return bits_from_mask(through);
  }

  template <int kLevelRotors>
  SKYBODY_INLINE MaskOf<Real> advance(const FreeRobot& robot, FreeMotion<Real>& motion,
                                      Real* end_speeds) const {
    const LaneValues<Real> q(at(call_.group.q, robot.q)), u(at(call_.group.u, robot.u));
    const auto load = [&]() SKYBODY_INLINE_LAMBDA {
      return FreeMotion<Real>{load_vec3(q), load_quat(q + 3), load_vec3(u), load_vec3(u + 3)};
    };
    using Step = FreeRobotStep<Real, LaneValues<Real>, Values, Values, kLevelRotors>;
    return Step(call_.robots, robot, in_).template advance<kIntegrator>(load, motion, end_speeds);
  }

  static SKYBODY_INLINE void put(double* p, const Real& value, const MaskOf<Real>& mask) {
    store_lanes(p, value, mask);
  }
  static SKYBODY_INLINE void put(double* p, const Real& value, bool) { store_lanes(p, value); }

  /// @param mask  lanes to write; or `true`: all, without reading what is overwritten
  template <int kLevelRotors, class Mask>
  SKYBODY_INLINE void write(const FreeRobot& robot, const FreeMotion<Real>& m,
                            const Real* end_speeds, const Mask& mask) const {
    const Real values[13] = {m.position.x, m.position.y, m.position.z, m.rotation.w, m.rotation.x,
                             m.rotation.y, m.rotation.z, m.velocity.x, m.velocity.y, m.velocity.z,
                             m.spin.x,     m.spin.y,     m.spin.z};
    // All places first: nothing needs to be looked up again between the stores.
    double *q = at(call_.group.q, robot.q), *u = at(call_.group.u, robot.u);
    double* bodies = at(call_.group.bodies, 13 * robot.body);
    double* rotor_speed = at(call_.group.rotor_speed, robot.rotors.first);
    const int rotors = kLevelRotors > 0 ? kLevelRotors : robot.rotors.count;
    for (int k = 0; k < 7; ++k) put(q + k * kGroupLanes, values[k], mask);
    for (int k = 0; k < 6; ++k) put(u + k * kGroupLanes, values[7 + k], mask);
    for (int k = 0; k < 13 && !call_.bodies_are_coordinates; ++k) {
      put(bodies + k * kGroupLanes, values[k], mask);
    }
#pragma GCC unroll 4
    for (int i = 0; i < rotors; ++i) put(rotor_speed + i * kGroupLanes, end_speeds[i], mask);
  }

  const FreeCall& call_;
  int first_;
  FreeStepInputs<LaneValues<Real>, Values, Values> in_;
  FreeMotion<Real>* motions_;  ///< at the step's end; only where there are several robots
  Real* end_speeds_;           ///< of all rotors
};

/// The kernel for packs of W lanes.
template <int W, IntegratorChoice kIntegrator>
SKYBODY_INLINE std::uint32_t advance_free(const PackCall& call, std::uint32_t lanes) {
  using Real = Pack<W>;
  const FreeCall free_call(call);
  return for_packs<W>(call, lanes,
                      [&](int first, std::uint32_t bits, const auto& params, const auto& derived)
                          SKYBODY_INLINE_LAMBDA {
                            FreePack<Real, std::decay_t<decltype(params)>, kIntegrator> pack(
                                free_call, first, params, derived);
                            return pack.advance(bits);
                          });
}

/// The kernels of rk4, a file of their own; the others are chosen by choose_free_kernel.
PackAdvance* choose_free_rk4_kernel();

}  // namespace skybody
