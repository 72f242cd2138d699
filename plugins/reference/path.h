// A reference as a function of time: a form, its pace, its heading, and the way onto it.
//
//   r(t) = p(s(t)) + o (1 - rise(t)),   yaw(t) = facing(s(t)) + heading
//
// p is the form by path time s, s(t) the clock, o the way from the path's beginning to where the
// vehicle was at the reset, and rise a smooth rise from 0 to 1, at whose end the clock begins.
#pragma once

#include "plugins/api/reference_point.h"
#include "plugins/reference/harmonic.h"
#include "plugins/reference/heading.h"
#include "plugins/reference/spline.h"

namespace skybody::reference {

enum class Kind { kLissajous, kCircle, kHelix, kFigureEight, kWaypoints, kCsv, kStep, kHold };

inline bool is_harmonic(Kind kind) { return kind <= Kind::kFigureEight; }
inline bool is_spline(Kind kind) { return kind == Kind::kWaypoints || kind == Kind::kCsv; }

/// Where the heading comes from: fixed, the path's direction, either of these by a drawn number, or
/// the path's own fourth curve.
enum class Facing { kFixed, kTangent, kDrawn, kTable };

/// What may differ from one environment to the next.
template <class Real>
struct PathNumbers {
  Harmonic<Real> figure;  ///< its centre and amplitude serve the other kinds, too
  Real rate;              ///< of a figure's angle by path time [rad/s]
  Real step_time;         ///< [s]
  Real time_scale;        ///< path time that passes in a second
  Real heading;           ///< [rad]
  Real along;             ///< of Facing::kDrawn: 0.5 and more is along the path
  Vec3<Real> offset;      ///< at the reset, from the path's beginning to the vehicle (W) [m]
};

/// A reference at one moment, with derivatives up to N - 1.
template <class Real, int N>
struct Moment {
  PathPoint<Real, N> point;  ///< W [m]
  Jet<Real, N> yaw;          ///< [rad]
};

/// The moment as signal `trajectory` has it.
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

/// What all environments have in common. Immutable once it is made.
struct Path {
  Kind kind = Kind::kHold;
  Facing facing = Facing::kFixed;
  double ramp = 0.0;      ///< of the clock [s]
  double approach = 0.0;  ///< way onto the path, before its clock runs [s]; 0: it begins there
  Spline spline = {};     ///< of waypoints and tables

  /// The reference at a time since the reset [s].
  template <int N, class Real>
  SKYBODY_INLINE Moment<Real, N> at(const PathNumbers<Real>& numbers, const Real& time) const {
    const Clock<Real> clock{approach, ramp, numbers.time_scale};
    const Jet<Real, N> path_time = clock.template at<N>(time);
    Moment<Real, N> moment = form<N>(numbers, path_time.c[0]);
    if (facing == Facing::kFixed) moment.yaw = Jet<Real, N>(0.0);
    if (facing == Facing::kTangent || facing == Facing::kDrawn) {
      moment.yaw = direction(moment.point, Real(0.0));
    }
    if (facing == Facing::kDrawn) {
      const auto looks_ahead = numbers.along >= 0.5;
      for (int k = 0; k < N; ++k) moment.yaw.c[k] = select(looks_ahead, moment.yaw.c[k], Real(0.0));
    }
    moment.point = composed(moment.point, path_time);
    moment.yaw = composed(moment.yaw, path_time);
    moment.yaw.c[0] = moment.yaw.c[0] + numbers.heading;
    if (approach > 0.0) join(numbers.offset, time, moment.point);
    return moment;
  }

  /// When the path is over and the reference rests [s]. A figure has no end: after a period at its
  /// full pace.
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
  /// By path time, with derivatives by path time.
  template <int N, class Real>
  SKYBODY_INLINE Moment<Real, N> form(const PathNumbers<Real>& numbers,
                                      const Real& path_time) const {
    using Number = Jet<Real, N>;
    if (is_harmonic(kind)) {
      const Number angle = Number::variable(numbers.rate * path_time, numbers.rate);
      return {numbers.figure.at(angle), Number(0.0)};
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

  /// Adds the rest of the way onto the path.
  template <int N, class Real>
  SKYBODY_INLINE void join(const Vec3<Real>& offset, const Real& time,
                           PathPoint<Real, N>& point) const {
    const Jet<Real, N> rest = 1.0 - smooth_rise<N>(time, approach);
    point = point + PathPoint<Real, N>{scaled(rest, offset.x), scaled(rest, offset.y),
                                       scaled(rest, offset.z)};
  }
};

}  // namespace skybody::reference
