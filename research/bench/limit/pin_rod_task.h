// The payload task on the QDrone2 with a rod on a pin: the rod's centre of mass is the payload.
#pragma once

#include "research/bench/limit/payload_task.h"
#include "research/bench/limit/pin_rod_flight.h"

namespace skybody::bench::limit {

/// Indices of the values of a Swinger in memory; the base's come first.
enum SwingerValue { kPinAngle = kFlyerValues, kPinRate, kSwingerValues };

/// Begins an episode as in research/bench/scenarios/pin_rod.yaml.
void begin_pin_rod(double* values, int stride, std::uint64_t env, std::uint64_t episode);

template <class R>
struct PinRodTask {
  using Real = R;
  static constexpr int kState = kSwingerValues, kValues = kSwingerValues;
  static constexpr int kOwnObservation = 22, kObservation = 26;
  static constexpr double kHorizon = 1000.0;
  static constexpr double kSpeedScale = 1123.0;  ///< rotor speed per (action + 1) [rad/s]
  static constexpr auto begin_episode = &begin_pin_rod;

  SKYBODY_INLINE Real& value(int k) {
    if (k < kPinAngle) return flyer_value(swinger.base, k);
    return k == kPinAngle ? swinger.angle : swinger.rate;
  }
  SKYBODY_INLINE void fly(const Real* command) { limit::fly(swinger, command); }

  template <class Get>
  SKYBODY_INLINE Outcome<Real> observe(Get&&, Real (&values)[kOwnObservation]) const {
    const Flyer<Real>& base = swinger.base;
    const SinCos<Real> half = sincos_of(0.5 * swinger.angle);
    const Quat<Real>& q = base.rotation;
    const Quat<Real> rotation{q.w * half.cos - q.y * half.sin, q.x * half.cos - q.z * half.sin,
                              q.w * half.sin + q.y * half.cos, q.x * half.sin + q.z * half.cos};
    // The base's rates in rod axes: rotated back about y.
    const Real sine = 2.0 * half.sin * half.cos, cosine = 1.0 - 2.0 * half.sin * half.sin;
    const Vec3<Real>& w = base.spin;
    const Vec3<Real> spin{cosine * w.x - sine * w.z, w.y + swinger.rate, sine * w.x + cosine * w.z};
    PointMotion<Real> load{base.position, base.velocity};
    load.descend(base.rotation, base.spin, kPinArm - kCom);
    load.descend(rotation, spin, kPinRod.arm);
    return observe_payload(base, load, spin, values);
  }

  Swinger<Real> swinger;
};

}  // namespace skybody::bench::limit
