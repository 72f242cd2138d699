// Progress of a racer: the next gate, whether a step passed or missed it, and lap times.
#pragma once

#include <skybody/task_kit.h>

#include "tasks/racing/track.h"

namespace skybody::racing {

/// State of a racer between two actions.
template <class Real>
struct RaceState {
  Real gates;           ///< number of gates passed in this episode
  Real distance;        ///< from the next gate's centre [m]
  Vec3<Real> position;  ///< W [m]
  Real lap_start;       ///< start time of the lap, since the reset [s]
  Real lap_time;        ///< duration of the last whole lap; 0: none yet [s]
};

/// A racer's RaceState in the task's buffer.
class PastWords {
 public:
  PastWords() = default;
  explicit PastWords(task_kit::BufferPlan& plan) : first_(plan.take(kWords)) {}

  template <class Real>
  SKYBODY_INLINE RaceState<Real> load(const Values<Real>& buffer) const {
    return {buffer[first_],
            buffer[first_ + 1],
            {buffer[first_ + 2], buffer[first_ + 3], buffer[first_ + 4]},
            buffer[first_ + 5],
            buffer[first_ + 6]};
  }
  template <class Real>
  SKYBODY_INLINE void store(const Values<Real>& buffer, const RaceState<Real>& past) const {
    buffer.set(first_, past.gates);
    buffer.set(first_ + 1, past.distance);
    buffer.set(first_ + 2, past.position);
    buffer.set(first_ + 5, past.lap_start);
    buffer.set(first_ + 6, past.lap_time);
  }
  /// Reads only the number of passed gates.
  template <class Real>
  SKYBODY_INLINE Real gates(const Values<Real>& buffer) const {
    return buffer[first_];
  }

 private:
  static constexpr int kWords = 7;
  int first_ = 0;
};

/// Effect of one action.
template <class Real>
struct Passage {
  MaskOf<Real> passed;  ///< the next gate was passed, in its direction
  MaskOf<Real> missed;  ///< its plane was crossed in its direction outside the opening
  Real gain;            ///< decrease of the distance from its centre [m]
};

/// Whether the straight line from the previous position to this one passes the gate: the signed
/// distance from the gate's plane changes from negative to positive, and the crossing point is in
/// the opening.
template <class Real>
SKYBODY_INLINE Passage<Real> passage(const Gate<Real>& gate, const Vec3<Real>& before,
                                     const Vec3<Real>& now) {
  const Vec3<Real> from = gate.local(before), to = gate.local(now);
  const MaskOf<Real> crossed = logical_and(from.x < 0.0, to.x >= 0.0);
  const Real way = select(crossed, to.x - from.x, Real(1.0));
  const MaskOf<Real> opens = gate.opens_at(from + (to - from) * (-from.x / way));
  return {logical_and(crossed, opens), logical_and(crossed, logical_not(opens)), Real(0.0)};
}

/// Advances by one action: passes the next gate if the motion led through it, and counts laps. At a
/// reset it initialises the state.
/// @param first  index of the gate at which the episode begins
/// @param time  since the reset [s]
template <class Real>
SKYBODY_INLINE Passage<Real> advance(const EnvView<Real>& env, const Track& track,
                                     const Real& first, const Real& time, const Vec3<Real>& now,
                                     RaceState<Real>& past) {
  const MaskOf<Real> stepped = env.step() > Word<Real>(0);
  const Gate<Real> gate = track.at(env, first + past.gates);
  Passage<Real> way = passage(gate, select(stepped, past.position, now), now);
  way.gain = task_kit::progress(env, norm(gate.centre - now), past.distance);
  past.position = now;
  past.gates = past.gates + select(way.passed, Real(1.0), Real(0.0));
  const double n = track.size();
  const MaskOf<Real> lapped = logical_and(way.passed, past.gates == n * floor(past.gates / n));
  past.lap_time = select(lapped, time - past.lap_start, past.lap_time);
  past.lap_start = select(lapped, time, past.lap_start);
  const Gate<Real> next = track.at(env, first + past.gates);
  past.distance = select(way.passed, norm(next.centre - now), past.distance);
  return way;
}

/// Goal for a baseline that holds goals: position and velocity.
template <class Real>
struct Lead {
  Vec3<Real> position, velocity;  ///< W [m], [m/s]
};

/// A goal on a line through the gate, moving along it at `pace` [m/s]. The goal waits before the
/// gate if the racer is off the line: 1.5 m for each metre beyond 0.2 m.
/// @param lane  offset of the line to the left of the gate's axis [m]
template <class Real>
SKYBODY_INLINE Lead<Real> lead(const Gate<Real>& gate, const Vec3<Real>& p, double pace,
                               double lane) {
  constexpr double kNear = 0.2, kWait = 1.5, kRoom = 0.5;  // [m], m/m, [m]
  const Vec3<Real> local = gate.local(p);
  const Real aside = norm(local.y - lane, local.z);
  const Real room = kRoom - local.x - kWait * max(aside - kNear, Real(0.0));
  const Vec3<Real> place{local.x + min(room, Real(0.0)), Real(lane), Real(0.0)};
  return {gate.centre + rotate(gate.rotation, place),
          gate.normal() * (pace * clamp(room / kRoom, Real(0.0), Real(1.0)))};
}

}  // namespace skybody::racing
