// The parameters of a path, for plugins that follow a path or evaluate one.
#pragma once

#include <skybody/plugin.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "plugins/reference/path.h"

namespace skybody::reference {

inline constexpr std::array<const char*, 8> kKindNames = {
    "lissajous", "circle", "helix", "figure_eight", "waypoints", "csv", "step", "hold"};

/// Reads the parameters of one environment, or of all lanes of a view.
template <class Real>
struct DrawnNumbers {
  const EnvView<Real>& env;
  Real operator()(const RealParameter& parameter) const { return parameter(env); }
  Vec3<Real> operator()(const RealsParameter& parameter) const { return parameter.vec3(env); }
};

/// Reads the parameters' values in the scenario.
struct NominalNumbers {
  double operator()(const RealParameter& parameter) const { return parameter.value(); }
  Vec3<double> operator()(const RealsParameter& parameter) const { return parameter.vec3(); }
};

/// Declare it as a member of the plugin `owner`.
class PathParameters {
 public:
  explicit PathParameters(Plugin* owner) : owner_(owner) {}

  Kind kind() const {
    const auto found = std::find(kKindNames.begin(), kKindNames.end(), name_.value());
    return static_cast<Kind>(found - kKindNames.begin());
  }

  /// The path. @throws std::runtime_error if parameters contradict one another, two waypoints
  /// coincide, or a table cannot be read
  Path path() const;

  /// All numbers except the rate and the offset, which path_start() computes.
  /// @param read  DrawnNumbers or NominalNumbers
  template <class Real, class Read>
  SKYBODY_INLINE PathNumbers<Real> numbers(const Read& read) const {
    const Vec3<Real> one{Real(1.0), Real(1.0), Real(1.0)}, zero{Real(0.0), Real(0.0), Real(0.0)};
    PathNumbers<Real> out{{read(centre_), read(amplitude_), one, zero, read(climb_)},
                          Real(0.0),
                          read(step_time_),
                          read(time_scale_),
                          read(heading_),
                          read(along_),
                          zero};
    const Kind own = kind();
    if (own == Kind::kLissajous) {
      out.figure.cycles = read(cycles_);
      out.figure.phase = read(phase_);
    } else if (own == Kind::kFigureEight) {
      out.figure.cycles.y = Real(2.0);
    } else {
      out.figure.phase.x = Real(kHalfPi);
    }
    return out;
  }

  /// Rate of a figure's angle [rad/s]: from the peak speed if given, otherwise from the period.
  template <class Real, class Read>
  SKYBODY_INLINE Real rate(const Read& read, const Harmonic<Real>& figure) const {
    const Real speed = read(peak_speed_), steepest = figure.steepest();
    const auto by_speed = logical_and(speed > 0.0, steepest > 0.0);
    return select(by_speed, speed / select(by_speed, steepest, Real(1.0)),
                  (2.0 * kPi) / read(period_));
  }

 private:
  void check() const;
  Spline through_waypoints() const;
  Facing facing(bool has_yaw) const;
  void refuse_if_given(const Parameter& parameter, const char* name,
                       std::initializer_list<Kind> used_by) const;
  std::vector<double> times_by_distance() const;
  void check_waypoints() const;

  Plugin* owner_;
  TextParameter name_{
      owner_, required(choice("kind", "", {kKindNames.begin(), kKindNames.end()}, "kind of path"))};
  RealsParameter centre_{owner_,
                         randomizable(reals("centre", "m", {0.0, 0.0, 0.0}, kAny,
                                            "centre of the figure, or offset of a path (W)"))};
  RealsParameter amplitude_{owner_,
                            randomizable(reals("amplitude", "m", {1.5, 1.5, 0.0}, kAny,
                                               "amplitude of each axis; of a step: its size (W)"))};
  RealsParameter cycles_{owner_,
                         randomizable(reals("cycles", "", {1.0, 2.0, 1.0}, between(0.0, 16.0),
                                            "lissajous: oscillations of each axis per period"))};
  RealsParameter phase_{
      owner_, randomizable(reals("phase", "rad", {kHalfPi, 0.0, 0.0}, between(-1e3, 1e3),
                                 "lissajous: initial phase of each axis; 0: at the centre"))};
  RealParameter climb_{owner_,
                       randomizable(real("climb", "m", 0.0, kAny, "helix: rise per period"))};
  RealParameter period_{owner_,
                        randomizable(real("period", "s", 8.0, between(1e-3, 1e6),
                                          "period of a figure; `peak_speed` takes precedence"))};
  RealParameter peak_speed_{
      owner_,
      randomizable(real("peak_speed", "m/s", 0.0, between(0.0, 1e3),
                        "largest speed on a figure, computed at the reset; 0: `period` determines "
                        "it. Waypoints without times: the times are chosen for it"))};
  RealsParameter waypoints_{owner_, list("waypoints", "m", {}, kAny,
                                         "x, y, z of each waypoint, one after the other (W)")};
  RealsParameter times_{
      owner_,
      list("times", "s", {}, at_least(0.0),
           "time of each waypoint; the first is 0. Without times: by distance, for `peak_speed`")};
  TextParameter file_{
      owner_,
      {.name = "file",
       .doc = "csv: table with the columns t [s], x, y, z [m] and optionally yaw [rad] (W)",
       .is_file = true}};
  RealParameter step_time_{owner_, randomizable(real("step_time", "s", 1.0, between(0.0, 1e6),
                                                     "step: path time of the jump"))};
  RealParameter time_scale_{owner_, randomizable(real("time_scale", "", 1.0, between(1e-3, 1e3),
                                                      "path time per second: 2 is twice as fast"))};
  RealParameter ramp_{owner_, real("ramp", "s", 2.0, between(0.0, 1e4),
                                   "time in which the pace rises from 0, for a vehicle at rest; "
                                   "paths other than harmonic ones take it only if given")};
  RealParameter approach_{
      owner_, real("approach", "s", 0.0, between(0.0, 1e4),
                   "time in which the reference moves from the base's initial position to the "
                   "path's beginning, before path time runs; 0: it begins there")};
  TextParameter yaw_{
      owner_, choice("yaw", "fixed", {"fixed", "tangent", "drawn", "table"},
                     "heading: `heading`, along the path, one of both by `along`, or the table's")};
  RealParameter heading_{owner_, randomizable(real("heading", "rad", 0.0, between(-1e3, 1e3),
                                                   "heading added to the yaw"))};
  RealParameter along_{
      owner_, randomizable(real("along", "", 1.0, between(0.0, 1.0),
                                "with `yaw: drawn`: 0.5 and more: along the path, less: fixed"))};
};

}  // namespace skybody::reference
