// A reference as a function of time: a curve, its pace, its heading, and the approach to it.
//
//   r(t) = p(s(t)) + o (1 - rise(t)),   yaw(t) = facing(s(t)) + heading
//
// p is the curve by path time s, and s(t) the clock. o is the offset from the path's beginning to
// the vehicle's position at the reset. rise goes smoothly from 0 to 1; the clock begins at its end.
#pragma once

#include "plugins/api/reference_point.h"
#include "plugins/reference/harmonic.h"
#include "plugins/reference/heading.h"
#include "plugins/reference/spline.h"

namespace skybody::reference {

enum class Kind { kLissajous, kCircle, kHelix, kFigureEight, kWaypoints, kCsv, kStep, kHold };

inline bool is_harmonic(Kind kind) { return kind <= Kind::kFigureEight; }
inline bool is_spline(Kind kind) { return kind == Kind::kWaypoints || kind == Kind::kCsv; }

/// Source of the heading: fixed, the path's direction, one of these two by a drawn number, or the
/// path's own fourth curve.
enum class Facing { kFixed, kTangent, kDrawn, kTable };

/// Numbers of a path that may differ between environments.
template <class Real>
struct PathNumbers {
  Harmonic<Real> figure;  ///< centre and amplitude apply to the other kinds, too
  Real rate;              ///< of a figure's angle by path time [rad/s]
  Real step_time;         ///< [s]
  Real time_scale;        ///< path time per second
  Real heading;           ///< [rad]
  Real along;             ///< of Facing::kDrawn: 0.5 or more means along the path
  Vec3<Real> offset;      ///< at the reset, from the path's beginning to the vehicle (W) [m]
};

/// A reference at one time, with derivatives up to order N - 1.
template <class Real, int N>
struct Moment {
  PathPoint<Real, N> point;  ///< W [m]
  Jet<Real, N> yaw;          ///< [rad]
};

/// Converts a moment to a point of signal `trajectory`.
template <class Real>
SKYBODY_INLINE ReferencePoint<Real> reference_point_of(const Moment<Real, kOrders>& moment) {
  return {derivative(moment.point, 0),
          derivative(moment.point, 1),
          derivative(moment.point, 2),
          derivative(moment.point, 3),
          derivative(moment.point, 4),
          wrap_angle(moment.yaw.c[0]),
          moment.yaw.c[1]};
}

/// The part of a path that all environments share. Immutable after construction.
struct Path {
  Kind kind = Kind::kHold;
  Facing facing = Facing::kFixed;
  double ramp = 0.0;      ///< time over which the clock reaches full pace [s]
  double approach = 0.0;  ///< duration of the approach, before the clock runs [s]; 0: none
  Spline spline = {};     ///< of waypoints and tables

  /// The reference at a time since the reset [s].
  template <int N, class Real>
  SKYBODY_INLINE Moment<Real, N> at(const PathNumbers<Real>& numbers, const Real& time) const {
    const Clock<Real> clock{approach, ramp, numbers.time_scale};
    const auto begins = time < approach + ramp;
    if (any(begins)) return beginning<N>(numbers, clock, time);
    Moment<Real, N> moment = form<N>(numbers, clock.steady(time));
    face(numbers, moment);
    for (Jet<Real, N>* part : {&moment.point.x, &moment.point.y, &moment.point.z, &moment.yaw}) {
      *part = paced(*part, numbers.time_scale);
    }
    return moment;
  }

  /// Time at which the path ends and the reference comes to rest [s]. A figure has no end: one
  /// period at full pace after the ramp.
  double length(const PathNumbers<double>& numbers) const {
    if (is_harmonic(kind)) {
      return approach + ramp + 2.0 * kPi / (numbers.rate * numbers.time_scale);
    }
    const double form = is_spline(kind) ? spline.end() - spline.begin() : 0.0;
    const Clock<double> clock{approach, ramp, numbers.time_scale};
    double low = approach, high = approach + ramp + form / numbers.time_scale;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (clock.at<1>(middle).c[0] < form ? low : high) = middle;
    }
    return high;
  }

 private:
  /// The same during the approach or the ramp; in lanes past them it has the same bits.
  template <int N, class Real>
  SKYBODY_INLINE Moment<Real, N> beginning(const PathNumbers<Real>& numbers,
                                           const Clock<Real>& clock, const Real& time) const {
    const Jet<Real, N> path_time = clock.template at<N>(time);
    Moment<Real, N> moment = form<N>(numbers, path_time.c[0]);
    face(numbers, moment);
    moment.point = composed(moment.point, path_time);
    moment.yaw = composed(moment.yaw, path_time);
    if (approach > 0.0) join(numbers.offset, time, moment.point);
    for (Jet<Real, N>* part : {&moment.point.x, &moment.point.y, &moment.point.z, &moment.yaw}) {
      for (int k = 0; k < N; ++k) part->c[k] = part->c[k] + 0.0;  // no -0, as in paced()
    }
    return moment;
  }

  /// Computes the heading, by path time.
  template <int N, class Real>
  SKYBODY_INLINE void face(const PathNumbers<Real>& numbers, Moment<Real, N>& moment) const {
    if (facing == Facing::kFixed) moment.yaw = Jet<Real, N>(0.0);
    if (facing == Facing::kTangent || facing == Facing::kDrawn) {
      moment.yaw = direction(moment.point, Real(0.0));
    }
    if (facing == Facing::kDrawn) {
      const auto looks_ahead = numbers.along >= 0.5;
      for (int k = 0; k < N; ++k) moment.yaw.c[k] = select(looks_ahead, moment.yaw.c[k], Real(0.0));
    }
    moment.yaw.c[0] = moment.yaw.c[0] + numbers.heading;
  }

  /// The curve by path time, with derivatives by path time.
  template <int N, class Real>
  SKYBODY_INLINE Moment<Real, N> form(const PathNumbers<Real>& numbers,
                                      const Real& path_time) const {
    using Number = Jet<Real, N>;
    if (is_harmonic(kind)) {
      return {numbers.figure.template at<N>(numbers.rate * path_time, numbers.rate), Number(0.0)};
    }
    Moment<Real, N> moment{{Number(0.0), Number(0.0), Number(0.0)}, Number(0.0)};
    Vec3<Real> shift = numbers.figure.centre;
    if (is_spline(kind)) {
      const auto sample = spline.template at<N>(path_time);
      moment = {sample.point, sample.yaw};
    } else if (kind == Kind::kStep) {
      const auto after = path_time >= numbers.step_time;
      const Vec3<Real>& size = numbers.figure.amplitude;
      shift += {select(after, size.x, Real(0.0)), select(after, size.y, Real(0.0)),
                select(after, size.z, Real(0.0))};
    }
    moment.point.x.c[0] = moment.point.x.c[0] + shift.x;
    moment.point.y.c[0] = moment.point.y.c[0] + shift.y;
    moment.point.z.c[0] = moment.point.z.c[0] + shift.z;
    return moment;
  }

  /// Adds the remaining offset of the approach.
  template <int N, class Real>
  SKYBODY_INLINE void join(const Vec3<Real>& offset, const Real& time,
                           PathPoint<Real, N>& point) const {
    const Jet<Real, N> rest = 1.0 - smooth_rise<N>(time, approach);
    point = point + PathPoint<Real, N>{scaled(rest, offset.x), scaled(rest, offset.y),
                                       scaled(rest, offset.z)};
  }
};

}  // namespace skybody::reference
