// The payload task on the QDrone2 with rod and bob.
#pragma once

#include "research/bench/limit/block_step.h"
#include "research/bench/limit/flight_ends.h"
#include "research/bench/limit/payload_flight.h"

namespace skybody::bench::limit {

/// Indices of the values of a Carrier in memory; the base's come first.
enum CarrierValue {
  kRodRotation = kFlyerValues,
  kRodSpin = kRodRotation + 4,
  kBobRotation = kRodSpin + 3,
  kBobSpin = kBobRotation + 4,
  kCarrierValues = kBobSpin + 3
};

/// Begins an episode as in scenarios/payload/payload.yaml, rod and bob hanging, nominal constants.
void begin_payload(double* values, int stride, std::uint64_t env, std::uint64_t episode);

/// Position and velocity of a point below other bodies.
template <class Real>
struct PointMotion {
  Vec3<Real> position, velocity;  ///< W [m, m/s]

  /// Moves to the point `length` down the z axis of a body that contains the current point.
  SKYBODY_INLINE void descend(const Quat<Real>& rotation, const Vec3<Real>& spin, double length) {
    const Mat3<Real> r = to_mat3(rotation);
    position -= r.column(2) * Real(length);
    velocity += (r.column(1) * spin.x - r.column(0) * spin.y) * Real(length);
  }
};

/// Observation of a payload task, without the action, and its end and reward.
template <class Real>
SKYBODY_INLINE Outcome<Real> observe_payload(const Flyer<Real>& base, const PointMotion<Real>& load,
                                             const Vec3<Real>& load_spin, Real (&values)[22]) {
  const Vec3<Real> error = load.position - Vec3<Real>{Real(0.0), Real(0.0), Real(0.5)};
  const Vec3<Real> offset = load.position - base.position;
  const Quat<Real> q = upright(base.rotation);
  const Vec3<Real>&v = base.velocity, w = base.spin, vl = load.velocity, wl = load_spin;
  const Real own[22] = {error.x, error.y, error.z, offset.x, offset.y, offset.z, q.w, q.x,
                        q.y,     q.z,     v.x,     v.y,      v.z,      w.x,      w.y, w.z,
                        vl.x,    vl.y,    vl.z,    wl.x,     wl.y,     wl.z};
  for (int k = 0; k < 22; ++k) values[k] = own[k];
  // 1 / (1 + 1.6 |e|^2) + 0.1 / (1 + |w_p|^2 + |w_u|^2) with one division.
  const Real near = 1.0 + 1.6 * squared_norm(error);
  const Real calm = 1.0 + (squared_norm(wl) + squared_norm(w));
  const Real failure = larger(tilted_or_far(base.rotation, base.position),
                              turned_too_far(heading_of(base.rotation)));
  return {pick(failure > Real(0.0), Real(-50.0), (calm + 0.1 * near) / (near * calm)), failure};
}

template <class R>
struct PayloadTask {
  using Real = R;
  static constexpr int kState = kCarrierValues, kValues = kCarrierValues;
  static constexpr int kOwnObservation = 22, kObservation = 26;
  static constexpr double kHorizon = 1000.0;
  static constexpr double kSpeedScale = 1123.0;  ///< rotor speed per (action + 1) [rad/s]
  static constexpr auto begin_episode = &begin_payload;

  SKYBODY_INLINE Real& value(int k) {
    if (k < kRodRotation) return flyer_value(carrier.base, k);
    Turning<Real>& body = k < kBobRotation ? carrier.rod : carrier.bob;
    switch ((k - kRodRotation) % 7) {
      case 0:
        return body.rotation.w;
      case 1:
        return body.rotation.x;
      case 2:
        return body.rotation.y;
      case 3:
        return body.rotation.z;
      case 4:
        return body.spin.x;
      case 5:
        return body.spin.y;
      default:
        return body.spin.z;
    }
  }
  SKYBODY_INLINE void fly(const Real* command) { limit::fly(carrier, command); }

  template <class Get>
  SKYBODY_INLINE Outcome<Real> observe(Get&&, Real (&values)[kOwnObservation]) const {
    const Flyer<Real>& base = carrier.base;
    const Turning<Real> rod = in_world({base.rotation, base.spin}, carrier.rod);
    const Turning<Real> bob = in_world(rod, carrier.bob);
    PointMotion<Real> load{base.position, base.velocity};
    load.descend(base.rotation, base.spin, kHookArm - kCom);
    load.descend(rod.rotation, rod.spin, 2.0 * kRodArm);
    load.descend(bob.rotation, bob.spin, kBobArm);
    return observe_payload(base, load, bob.spin, values);
  }

  Carrier<Real> carrier;

 private:
  /// @param parent, body  the parent relative to W, and the body relative to its parent
  static SKYBODY_INLINE Turning<Real> in_world(const Turning<Real>& parent,
                                               const Turning<Real>& body) {
    return {parent.rotation * body.rotation,
            rotate_inverse(body.rotation, parent.spin) + body.spin};
  }
};

}  // namespace skybody::bench::limit
