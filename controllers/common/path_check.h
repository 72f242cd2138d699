// Feasibility check of a path by a robot, with its parameters, for plugins that have a path.
#pragma once

#include <stdexcept>

#include "controllers/common/feasibility.h"
#include "plugins/reference/path_start.h"

namespace skybody::control {

/// Declared as a member of the plugin `owner`.
class PathCheck {
 public:
  explicit PathCheck(Plugin* owner) : owner_(owner) {}

  /// Rejects a path that never leaves its start; use `hold` instead. The distance between waypoints
  /// is checked when they are read.
  /// @throws std::runtime_error with the remedy
  static void require_length(const reference::PathParameters& parameters,
                             const reference::Path& path) {
    const reference::PathNumbers<double> numbers = nominal_numbers(parameters, path);
    if (is_harmonic(path.kind) && !(numbers.figure.steepest() > 0.0)) {
      refuse(
          "the path has no length: give `amplitude` a swing that has `cycles`, or take `kind: "
          "hold`");
    }
    if (path.kind == reference::Kind::kStep && !(norm(numbers.figure.amplitude) > 0.0)) {
      refuse("the step has no length: give `amplitude` the way that it goes, or take `kind: hold`");
    }
    const bool turns = path.facing == reference::Facing::kTable;
    if (path.kind == reference::Kind::kCsv && !turns && !(path.spline.peak_speed() > 0.0)) {
      refuse("the path of `file` has no length: let x, y or z change, or take `kind: hold`");
    }
  }

  /// Checks the nominal path, from its beginning on, against the robot's limits. Robots without
  /// rotors are driven and are not checked; neither is a step, which no vehicle can follow exactly.
  /// @throws std::runtime_error with the violated limit, its time, its excess and the remedy
  void require_flyable_path(const Setup& setup, int robot,
                            const reference::PathParameters& parameters,
                            reference::Path path) const {
    if (!check_.value() || setup.rotors_of(robot).size() == 0) return;
    if (path.kind == reference::Kind::kStep) return;
    FlightEnvelope envelope;
    envelope.configure(setup, robot, max_tilt_.value(), max_rate_.value());
    const reference::PathNumbers<double> numbers = nominal_numbers(parameters, path);
    path.approach = 0.0;  // the approach's start is random
    const auto at_scale = [&](double scale) {
      reference::PathNumbers<double> paced = numbers;
      paced.time_scale = scale;
      return paced;
    };
    const auto point = [&](double time, double scale) {
      return reference_point_of(path.at<reference::kOrders>(at_scale(scale), time));
    };
    const auto duration = [&](double scale) { return path.length(at_scale(scale)); };
    const bool ends = is_spline(path.kind);
    require_feasible(envelope, PacedReference{point, duration, ends}, numbers.time_scale);
  }

 private:
  Plugin* owner_;
  BooleanParameter check_{
      owner_,
      boolean("check", true,
              "reject a path that the robot cannot fly, by its nominal constants in still air")};
  RealParameter max_tilt_{owner_,
                          real("max_tilt", "rad", kPi, between(1e-3, kPi),
                               "check: largest angle between the base's z axis and the vertical")};
  RealParameter max_rate_{owner_, real("max_rate", "rad/s", 35.0, between(1e-3, 1e4),
                                       "check: largest body rate about each axis; default: range "
                                       "of common gyroscopes, 2000 degrees/s")};
};

}  // namespace skybody::control
