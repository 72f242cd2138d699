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
  TextParameter name_{owner_,
                      {.name = "kind",
                       .choices = {kKindNames.begin(), kKindNames.end()},
                       .doc = "kind of path",
                       .required = true}};
  RealsParameter centre_{owner_,
                         {.name = "centre",
                          .unit = "m",
                          .values = {0.0, 0.0, 0.0},
                          .doc = "centre of the figure, or offset of a path (W)",
                          .randomizable = true}};
  RealsParameter amplitude_{owner_,
                            {.name = "amplitude",
                             .unit = "m",
                             .values = {1.5, 1.5, 0.0},
                             .doc = "amplitude of each axis; of a step: its size (W)",
                             .randomizable = true}};
  RealsParameter cycles_{owner_,
                         {.name = "cycles",
                          .values = {1.0, 2.0, 1.0},
                          .min = 0.0,
                          .max = 16.0,
                          .doc = "lissajous: oscillations of each axis per period",
                          .randomizable = true}};
  RealsParameter phase_{owner_,
                        {.name = "phase",
                         .unit = "rad",
                         .values = {kHalfPi, 0.0, 0.0},
                         .min = -1e3,
                         .max = 1e3,
                         .doc = "lissajous: initial phase of each axis; 0: at the centre",
                         .randomizable = true}};
  RealParameter climb_{
      owner_,
      {.name = "climb", .unit = "m", .doc = "helix: rise per period", .randomizable = true}};
  RealParameter period_{owner_,
                        {.name = "period",
                         .unit = "s",
                         .value = 8.0,
                         .min = 1e-3,
                         .max = 1e6,
                         .doc = "period of a figure; `peak_speed` takes precedence",
                         .randomizable = true}};
  RealParameter peak_speed_{
      owner_,
      {.name = "peak_speed",
       .unit = "m/s",
       .min = 0.0,
       .max = 1e3,
       .doc = "largest speed on a figure, computed at the reset; 0: `period` determines it. "
              "Waypoints without times: the times are chosen for it",
       .randomizable = true}};
  RealsParameter waypoints_{owner_,
                            {.name = "waypoints",
                             .unit = "m",
                             .count = -1,
                             .doc = "x, y, z of each waypoint, one after the other (W)"}};
  RealsParameter times_{
      owner_,
      {.name = "times",
       .unit = "s",
       .count = -1,
       .min = 0.0,
       .doc =
           "time of each waypoint; the first is 0. Without times: by distance, for `peak_speed`"}};
  TextParameter file_{
      owner_,
      {.name = "file",
       .doc = "csv: table with the columns t [s], x, y, z [m] and optionally yaw [rad] (W)",
       .is_file = true}};
  RealParameter step_time_{owner_,
                           {.name = "step_time",
                            .unit = "s",
                            .value = 1.0,
                            .min = 0.0,
                            .max = 1e6,
                            .doc = "step: path time of the jump",
                            .randomizable = true}};
  RealParameter time_scale_{owner_,
                            {.name = "time_scale",
                             .value = 1.0,
                             .min = 1e-3,
                             .max = 1e3,
                             .doc = "path time per second: 2 is twice as fast",
                             .randomizable = true}};
  RealParameter ramp_{owner_,
                      {.name = "ramp",
                       .unit = "s",
                       .value = 2.0,
                       .min = 0.0,
                       .max = 1e4,
                       .doc = "time in which the pace rises from 0, for a vehicle at rest; for "
                              "waypoints and tables only if given"}};
  RealParameter approach_{
      owner_,
      {.name = "approach",
       .unit = "s",
       .min = 0.0,
       .max = 1e4,
       .doc = "time in which the reference moves from the base's initial position to the path's "
              "beginning, before path time runs; 0: it begins there"}};
  TextParameter yaw_{
      owner_,
      {.name = "yaw",
       .value = "fixed",
       .choices = {"fixed", "tangent", "drawn", "table"},
       .doc = "heading: `heading`, along the path, one of both by `along`, or the table's"}};
  RealParameter heading_{owner_,
                         {.name = "heading",
                          .unit = "rad",
                          .min = -1e3,
                          .max = 1e3,
                          .doc = "heading added to the yaw",
                          .randomizable = true}};
  RealParameter along_{owner_,
                       {.name = "along",
                        .value = 1.0,
                        .min = 0.0,
                        .max = 1.0,
                        .doc = "with `yaw: drawn`: 0.5 and more: along the path, less: fixed",
                        .randomizable = true}};
};

}  // namespace skybody::reference
