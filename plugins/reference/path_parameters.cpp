#include "plugins/reference/path_parameters.h"

#include <stdexcept>
#include <utility>

#include "plugins/reference/path_table.h"

namespace skybody::reference {

namespace {

/// Two waypoints closer than this [m] coincide.
constexpr double kNearest = 1e-3;

std::string at(const char* list, int i) {
  return "`" + std::string(list) + "[" + std::to_string(i) + "]`";
}

}  // namespace

Path PathParameters::path() const {
  check();
  Path path;
  path.kind = kind();
  bool has_yaw = false;
  if (path.kind == Kind::kWaypoints) path.spline = through_waypoints();
  if (path.kind == Kind::kCsv) {
    PathTable table = read_path_table(file_.value());
    path.spline = std::move(table.spline);
    has_yaw = table.has_yaw;
  }
  path.facing = facing(has_yaw);
  path.ramp = ramp_.is_given() || is_harmonic(path.kind) ? ramp_.value() : 0.0;
  path.approach = approach_.value();
  return path;
}

Facing PathParameters::facing(bool has_yaw) const {
  if (yaw_.value() == "tangent") return Facing::kTangent;
  if (yaw_.value() == "fixed") return Facing::kFixed;
  if (yaw_.value() == "drawn") return Facing::kDrawn;
  if (has_yaw) return Facing::kTable;
  refuse(
      "`yaw: table` needs a column `yaw` in the file of `kind: csv`; add it, or take `fixed`, "
      "`tangent` or `drawn`");
}

void PathParameters::refuse_if_given(const Parameter& parameter, const char* name,
                                     std::initializer_list<Kind> used_by) const {
  const Kind own = kind();
  if (!parameter.is_given() || std::find(used_by.begin(), used_by.end(), own) != used_by.end()) {
    return;
  }
  std::string kinds;
  for (const Kind kind : used_by) {
    kinds += (kinds.empty() ? "" : ", ") + std::string(kKindNames[static_cast<std::size_t>(kind)]);
  }
  refuse("`", name, "` says nothing with `kind: ", name_.value(), "`; it belongs to ", kinds,
         ": leave it out (`", name,
         ": ~` removes what an included file gives), or take one of these kinds");
}

void PathParameters::check() const {
  using enum Kind;
  refuse_if_given(amplitude_, "amplitude", {kLissajous, kCircle, kHelix, kFigureEight, kStep});
  refuse_if_given(cycles_, "cycles", {kLissajous});
  refuse_if_given(phase_, "phase", {kLissajous});
  refuse_if_given(climb_, "climb", {kHelix});
  refuse_if_given(period_, "period", {kLissajous, kCircle, kHelix, kFigureEight});
  refuse_if_given(peak_speed_, "peak_speed",
                  {kLissajous, kCircle, kHelix, kFigureEight, kWaypoints});
  refuse_if_given(waypoints_, "waypoints", {kWaypoints});
  refuse_if_given(times_, "times", {kWaypoints});
  refuse_if_given(file_, "file", {kCsv});
  if (along_.is_given() && yaw_.value() != "drawn") {
    refuse("`along` says nothing with `yaw: ", yaw_.value(),
           "`: leave it out, or take `yaw: drawn`");
  }
  refuse_if_given(step_time_, "step_time", {kStep});
  if (period_.is_given() && peak_speed_.value() > 0.0) {
    refuse("`period` ", period_.value(), " s and `peak_speed` ", peak_speed_.value(),
           " m/s are both given, and each says how fast the figure is flown: leave one out");
  }
  if (kind() == kCsv && file_.value().empty()) {
    refuse("`kind: csv` needs `file`: give a table with the columns t, x, y, z");
  }
}

void PathParameters::check_waypoints() const {
  const int count = waypoints_.count() / 3;
  if (waypoints_.count() % 3 != 0 || count < 2) {
    refuse("`waypoints` has ", waypoints_.count(),
           " values; allowed: three for each of two or more waypoints");
  }
  for (int i = 1; i < count; ++i) {
    const auto place = [&](int k) {
      return Vec3<double>{waypoints_.value(3 * k), waypoints_.value(3 * k + 1),
                          waypoints_.value(3 * k + 2)};
    };
    const double distance = norm(place(i) - place(i - 1));
    if (distance >= kNearest) continue;
    refuse("waypoints ", i - 1, " and ", i, " are ", distance,
           " m apart, which is on one another; allowed: 0.001 m or more. Leave one out");
  }
  if (times_.is_given() == (peak_speed_.value() > 0.0)) {
    throw std::runtime_error(
        times_.is_given() ? "`times` and `peak_speed` are both given, and each says how fast the "
                            "waypoints are flown: leave one out"
                          : "`waypoints` are given without a pace: add `times`, or `peak_speed`");
  }
  if (!times_.is_given()) return;
  if (times_.count() != count || times_.value(0) != 0.0) {
    refuse("`times` has ", times_.count(), " values, the first ", times_.value(0),
           " s; allowed: ", count, ", one for each waypoint, from 0 s on");
  }
  for (int i = 1; i < count; ++i) {
    if (times_.value(i) > times_.value(i - 1)) continue;
    refuse(at("times", i), " is ", times_.value(i), " s, not after the one before, ",
           times_.value(i - 1), " s: let times grow");
  }
}

std::vector<double> PathParameters::times_by_distance() const {
  constexpr double kAtRest = 1.5;  // factor on the duration of a piece that begins or ends at rest
  const int count = waypoints_.count() / 3;
  std::vector<double> times = {0.0};
  for (int i = 1; i < count; ++i) {
    Vec3<double> way{};
    way.x = waypoints_.value(3 * i) - waypoints_.value(3 * i - 3);
    way.y = waypoints_.value(3 * i + 1) - waypoints_.value(3 * i - 2);
    way.z = waypoints_.value(3 * i + 2) - waypoints_.value(3 * i - 1);
    const bool is_at_rest = i == 1 || i + 1 == count;
    times.push_back(times.back() + norm(way) * (is_at_rest ? kAtRest : 1.0));
  }
  return times;
}

Spline PathParameters::through_waypoints() const {
  check_waypoints();
  const int count = waypoints_.count() / 3;
  std::vector<double> values, times;
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) values.push_back(waypoints_.value(3 * i + k));
    values.push_back(0.0);
    if (times_.is_given()) times.push_back(times_.value(i));
  }
  if (times_.is_given()) return Spline(times, values, SplineEnds::kRest);
  const Spline spline(times_by_distance(), values, SplineEnds::kRest);
  return spline.stretched(spline.peak_speed() / peak_speed_.value());
}

}  // namespace skybody::reference
