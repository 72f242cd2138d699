// Kernels of worlds whose robots are one free body each (free_robot_step.h).
#pragma once

#include "core/physics/step/free_robot_step.h"
#include "core/physics/step/group_kernels.h"

namespace skybody {

/// A physics step of all robots of the lanes of one Real.
template <class Real, class Values, IntegratorChoice kIntegrator, HeldInputSet kHeld,
          SpinKind kSpin>
class FreeLanes {
 public:
  SKYBODY_INLINE FreeLanes(const StepCall& call, int first, const Values& params,
                           const Values& derived)
      : robots_(*call.plan->free_robots),
        q_(call.group->q),
        u_(call.group->u),
        bodies_(call.group->bodies == q_ ? nullptr : call.group->bodies),
        rotor_speed_(call.group->rotor_speed),
        lanes_(first),
        in_{LaneValues<Real>(rotor_speed_ + first),
            LaneValues<Real>(call.group->rotor_command + first),
            LaneValues<Real>(call.group->wrench + first),
            HeldLanes<Real>(call.group->held, first),
            params,
            derived + call.plan->derived.lags,
            derived + call.plan->derived.factors,
            derived + call.plan->derived.bodies},
        motions_(reinterpret_cast<FreeMotion<Real>*>(call.scratch)),
        end_speeds_(reinterpret_cast<Real*>(motions_ + robots_.robots.size())) {}

  /// @returns the lanes of `lanes` that succeeded; the others are unchanged
  SKYBODY_INLINE std::uint32_t advance(std::uint32_t lanes) const {
    const std::vector<FreeRobot>& robots = robots_.robots;
    Real end_speeds[4];
    if constexpr (kHeld == HeldInputSet::kAnything) {
      return advance_all(lanes);  // one variant only: each takes long to compile
    } else if constexpr (kHeld == HeldInputSet::kAir) {
      return advance_one<kMeasured>(robots[0], end_speeds, lanes);
    } else {
      if (robots.size() > 1) return advance_all(lanes);
      if (is_measured(robots[0])) return advance_one<kMeasured>(robots[0], end_speeds, lanes);
      return advance_one<FreeKind::kAny>(robots[0], end_speeds_, lanes);
    }
  }

 private:
  static constexpr std::uint32_t kAll = (1u << kLanesOf<Real>)-1u;
  static constexpr bool kIsNominal = std::is_same_v<Values, SharedValues<Real>>;
  /// The kind of a world's only robot for which a specialised step is compiled, besides kAny.
  static constexpr FreeKind kMeasured =
      kIsNominal ? FreeKind::kPlainQuadrotor : FreeKind::kQuadrotor;

  static bool is_measured(const FreeRobot& robot) {
    return kIsNominal ? robot.is_plain_quadrotor : robot.has_four_level_rotors();
  }

  /// Steps the only robot of a world.
  template <FreeKind kKind>
  SKYBODY_INLINE std::uint32_t advance_one(const FreeRobot& robot, Real* end_speeds,
                                           std::uint32_t lanes) const {
    FreeMotion<Real> motion;
    const MaskOf<Real> sound = advance<kKind>(robot, motion, end_speeds);
    if (lanes == kAll && all(sound)) {  // the usual case, without a mask
      write<kKind>(robot, motion, end_speeds, AllLanes());
      return lanes;
    }
    const MaskOf<Real> through = sound & mask_from_bits<Real>(lanes);
    write<kKind>(robot, motion, end_speeds, through);
    return bits_from_mask(through);
  }

  /// Steps all robots first, then writes the lanes in which all of them succeeded.
  SKYBODY_INLINE std::uint32_t advance_all(std::uint32_t lanes) const {
    MaskOf<Real> through = mask_from_bits<Real>(lanes);
    FreeMotion<Real>* at_end = motions_;
    for (const FreeRobot& robot : robots_.robots) {
      FreeMotion<Real> motion;
      Real* end_speeds = end_speeds_ + robot.rotors.first;
      if constexpr (kHeld == HeldInputSet::kAnything) {
        through &= advance<FreeKind::kAny>(robot, motion, end_speeds);
      } else {
        through &= robot.has_four_level_rotors()
                       ? advance<FreeKind::kQuadrotor>(robot, motion, end_speeds)
                       : advance<FreeKind::kAny>(robot, motion, end_speeds);
      }
      *at_end++ = motion;
    }
    if (all(through)) {
      write_all(AllLanes());
    } else {
      write_all(through);
    }
    return bits_from_mask(through);
  }

  template <FreeKind kKind>
  SKYBODY_INLINE MaskOf<Real> advance(const FreeRobot& robot, FreeMotion<Real>& motion,
                                      Real* end_speeds) const {
    const LaneValues<Real> q(lanes_.at(q_, first_place<kKind>(robot.q)));
    const LaneValues<Real> u(lanes_.at(u_, first_place<kKind>(robot.u)));
    const auto load = [&]() SKYBODY_INLINE_LAMBDA {
      return FreeMotion<Real>{load_vec3(q), load_quat(q + 3), load_vec3(u), load_vec3(u + 3)};
    };
    using Step = FreeRobotStep<Real, Values, kKind, kHeld, kSpin>;
    return Step(robots_, robot, in_).template advance<kIntegrator>(load, motion, end_speeds);
  }

  template <class Mask>
  SKYBODY_INLINE void write_all(const Mask& mask) const {
    const FreeMotion<Real>* motion = motions_;
    for (const FreeRobot& robot : robots_.robots) {
      write<FreeKind::kAny>(robot, *motion++, end_speeds_ + robot.rotors.first, mask);
    }
  }

  /// @param mask  lanes to write, or AllLanes
  template <FreeKind kKind, class Mask>
  SKYBODY_INLINE void write(const FreeRobot& robot, const FreeMotion<Real>& m,
                            const Real* end_speeds, const Mask& mask) const {
    const Real values[13] = {m.position.x, m.position.y, m.position.z, m.rotation.w, m.rotation.x,
                             m.rotation.y, m.rotation.z, m.velocity.x, m.velocity.y, m.velocity.z,
                             m.spin.x,     m.spin.y,     m.spin.z};
    // All addresses first: no look-up is needed between the stores.
    double* q = lanes_.at(q_, first_place<kKind>(robot.q));
    double* u = lanes_.at(u_, first_place<kKind>(robot.u));
    const int body = first_place<kKind>(robot.body);
    double* bodies = bodies_ == nullptr ? nullptr : lanes_.at(bodies_, 13 * body);
    double* rotor_speed = lanes_.at(rotor_speed_, first_place<kKind>(robot.rotors.first));
    const int rotors = kKind == FreeKind::kAny ? robot.rotors.count : 4;
    const LaneSlice<Real> here(0);
    here.store(values, 7, mask, q);
    here.store(values + 7, 6, mask, u);
    if (bodies != nullptr) here.store(values, 13, mask, bodies);
#pragma GCC unroll 4
    for (int i = 0; i < rotors; ++i) here.put(end_speeds[i], mask, here.at(rotor_speed, i));
  }

  const FreeRobots& robots_;
  // Copies, so that the compiler sees that stores cannot change them.
  double *q_, *u_;
  double* bodies_;  ///< null: the bodies' motion is q and u
  double* rotor_speed_;
  LaneSlice<Real> lanes_;
  FreeStepInputs<Real, Values> in_;
  FreeMotion<Real>* motions_;  ///< at the step's end; only for several robots
  Real* end_speeds_;           ///< of all rotors
};

template <IntegratorChoice kIntegrator, HeldInputSet kHeld, SpinKind kSpin = SpinKind::kSlow>
struct AdvanceFreeRobots {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    constexpr bool kNeverShared = kHeld == HeldInputSet::kAnything && kSpin == SpinKind::kSlow;
    return for_packs<W, kNeverShared>(
        call, lanes,
        [&](int first, std::uint32_t bits, const auto& params, const auto& derived)
            SKYBODY_INLINE_LAMBDA {
              using Values = std::decay_t<decltype(params)>;
              using Lanes = FreeLanes<RealOf<W>, Values, kIntegrator, kHeld, kSpin>;
              return Lanes(call, first, params, derived).advance(bits);
            });
  }
};

}  // namespace skybody
