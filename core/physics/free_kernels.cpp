// The kernels of FreeRobotStep on packs, for each instruction set.
#include "core/base/isa.h"
#include "core/base/kernel_target.h"
#include "core/physics/free_robot_step.h"
#include "core/physics/pack_call.h"

namespace skybody {
namespace {

/// A physics step of all robots of the lanes in one pack.
template <class Real, class Values>
class FreePack {
 public:
  using Step = FreeRobotStep<Real, LaneValues<Real>, Values, Values>;

  SKYBODY_INLINE FreePack(const PackCall& call, int first, const Values& params,
                          const Values& derived)
      : robots_(*call.world->free_robots),
        group_(*call.group),
        bodies_are_coordinates_(call.group->bodies == call.group->q),
        first_(first),
        in_{LaneValues<Real>(group_.rotor_speed + first),
            LaneValues<Real>(group_.rotor_command + first),
            LaneValues<Real>(group_.wrench + first),
            params,
            derived + call.world->derived.lags,
            derived + call.world->derived.bodies},
        motions_(reinterpret_cast<FreeMotion<Real>*>(call.scratch)),
        end_speeds_(reinterpret_cast<Real*>(motions_ + robots_.robots.size())) {}

  /// @returns the lanes of `mask` that came through; the others are as they were
  SKYBODY_INLINE MaskOf<Real> advance(const MaskOf<Real>& mask) {
    MaskOf<Real> through = mask;
    const std::size_t count = robots_.robots.size();
    for (std::size_t r = 0; r < count; ++r) {
      FreeMotion<Real> motion;
      through &= advance(robots_.robots[r], motion);
      if (count == 1) {
        store(robots_.robots[r], motion, through);
      } else {
        motions_[r] = motion;  // whether all came through is not known yet
      }
    }
    for (std::size_t r = 0; r < count && count > 1; ++r) {
      store(robots_.robots[r], motions_[r], through);
    }
    return through;
  }

 private:
  template <class T>
  SKYBODY_INLINE T* at(T* block, int k) const {
    return block + static_cast<std::ptrdiff_t>(k) * kGroupLanes + first_;
  }
  SKYBODY_INLINE MaskOf<Real> advance(const FreeRobot& robot, FreeMotion<Real>& motion) const {
    const LaneValues<Real> q(at(group_.q, robot.q)), u(at(group_.u, robot.u));
    const auto load = [&]() __attribute__((always_inline)) {
      return FreeMotion<Real>{load_vec3(q), load_quat(q + 3), load_vec3(u), load_vec3(u + 3)};
    };
    return Step(robots_, robot, in_).advance(load, motion, end_speeds_ + robot.rotors.first);
  }

  /// In all lanes that came through: usually all, without reading what is overwritten.
  SKYBODY_INLINE void store(const FreeRobot& robot, const FreeMotion<Real>& motion,
                            const MaskOf<Real>& through) const {
    if (all(through)) {
      write(robot, motion, true);
    } else {
      write(robot, motion, through);
    }
  }

  static SKYBODY_INLINE void put(double* p, const Real& value, const MaskOf<Real>& mask) {
    store_lanes(p, value, mask);
  }
  static SKYBODY_INLINE void put(double* p, const Real& value, bool) { store_lanes(p, value); }

  /// @param mask  lanes to write; or `true`: all
  template <class Mask>
  SKYBODY_INLINE void write(const FreeRobot& robot, const FreeMotion<Real>& m,
                            const Mask& mask) const {
    const Real values[13] = {m.position.x, m.position.y, m.position.z, m.rotation.w, m.rotation.x,
                             m.rotation.y, m.rotation.z, m.velocity.x, m.velocity.y, m.velocity.z,
                             m.spin.x,     m.spin.y,     m.spin.z};
    for (int k = 0; k < 7; ++k) put(at(group_.q, robot.q + k), values[k], mask);
    for (int k = 0; k < 6; ++k) put(at(group_.u, robot.u + k), values[7 + k], mask);
    for (int k = 0; k < 13 && !bodies_are_coordinates_; ++k) {
      put(at(group_.bodies, 13 * robot.body + k), values[k], mask);
    }
    for (int i = robot.rotors.first; i < robot.rotors.first + robot.rotors.count; ++i) {
      put(at(group_.rotor_speed, i), end_speeds_[i], mask);
    }
  }

  const FreeRobots& robots_;
  const GroupBlocks& group_;
  bool bodies_are_coordinates_;
  int first_;
  typename Step::Inputs in_;
  FreeMotion<Real>* motions_;  ///< at the step's end
  Real* end_speeds_;           ///< of all rotors
};

/// The kernels for packs of W lanes.
template <int W>
SKYBODY_INLINE std::uint32_t advance(const PackCall& call, std::uint32_t lanes) {
  using Real = Pack<W>;
  return for_packs<W>(
      call, lanes,
      [&](int first, std::uint32_t bits, const auto& params, const auto& derived)
          __attribute__((always_inline)) {
            FreePack<Real, std::decay_t<decltype(params)>> pack(call, first, params, derived);
            return bits_from_mask(pack.advance(mask_from_bits<Real>(bits)));
          });
}

// One function per instruction set. A macro, because the target is an attribute.
#define SKYBODY_FREE_KERNEL(NAME, TARGET, WIDTH)                            \
  SKYBODY_KERNEL(TARGET)                                                    \
  std::uint32_t advance_##NAME(const PackCall& call, std::uint32_t lanes) { \
    return advance<WIDTH>(call, lanes);                                     \
  }
SKYBODY_FREE_KERNEL(v2, "arch=x86-64-v2", 2)
SKYBODY_FREE_KERNEL(v3, "arch=x86-64-v3", 4)
SKYBODY_FREE_KERNEL(v4, "arch=x86-64-v4", 8)
#undef SKYBODY_FREE_KERNEL

}  // namespace

PackAdvance* choose_free_kernel() {
  switch (best_isa()) {
    case Isa::v4:
      return &advance_v4;
    case Isa::v3:
      return &advance_v3;
    case Isa::v2:
      break;
  }
  return &advance_v2;
}

std::size_t free_kernel_scratch(const FreeRobots& robots) {
  return robots.robots.size() * sizeof(FreeMotion<Pack<kGroupLanes>>) +
         robots.rotors.size() * sizeof(Pack<kGroupLanes>);
}

}  // namespace skybody
