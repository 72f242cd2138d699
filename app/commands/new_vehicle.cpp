#include "app/commands/new_vehicle.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/system/error.h"
#include "core/io/files/text.h"
#include "core/io/yaml/plausibility_limits.h"
#include "core/model/constants.h"
#include "randomization/vehicle/laws.h"

namespace skybody {
namespace {

using randomization::VehicleLaws;
using randomization::VehicleRotors;

constexpr double kStandardGravity = 9.81;  // [m/s^2], for a scenario without gravity
constexpr double kBodyHeight = 0.3;        // of the collision shape, relative to the arm
constexpr double kHubRadius = 0.3;         // of the body in pictures, relative to the arm's length
constexpr double kBarWidth = 0.06;         // of an arm in pictures, relative to the arm's length

/// Six significant digits: the scaling laws are less precise.
std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", std::fabs(value) < 1e-12 ? 0.0 : value);
  return text;
}

/// The middle of the randomizer's range.
double middle(int quantity) {
  const randomization::Range& range = randomization::kVehicleRows[quantity].scaling;
  return 0.5 * (range.low + range.high);
}

bool is_used(int quantity) { return randomization::kVehicleRows[quantity].scaling.is_used(); }

/// Azimuths of the hubs from the x axis, counter-clockwise [rad].
std::vector<double> azimuths(const VehicleOptions& options) {
  const double step = 2.0 * std::numbers::pi / options.rotors;
  std::vector<double> angles;
  for (int k = 0; k < options.rotors; ++k) {
    angles.push_back(step * (options.layout == "x" ? k + 0.5 : k));
  }
  return angles;
}

std::string rotor_lines(const VehicleOptions& options) {
  std::string text;
  int k = 0;
  for (const double angle : azimuths(options)) {
    text += (k == 0 ? "" : "\n") + ("  - {name: rotor_" + std::to_string(k)) + ", position: [" +
            number(options.arm * std::cos(angle)) + ", " + number(options.arm * std::sin(angle)) +
            ", 0], direction: " + (k % 2 == 0 ? "cw" : "ccw") + "}";
    ++k;
  }
  return text;
}

std::string arm_lines(const VehicleOptions& options) {
  std::string text;
  for (const double angle : azimuths(options)) {
    text += "    <visual>\n      <origin xyz=\"" + number(0.5 * options.arm * std::cos(angle)) +
            " " + number(0.5 * options.arm * std::sin(angle)) + " 0\" rpy=\"0 0 " + number(angle) +
            "\"/>\n      <geometry><box size=\"" + number(options.arm) + " " +
            number(kBarWidth * options.arm) + " " + number(kBarWidth * options.arm) +
            "\"/></geometry>\n      <material name=\"dark\"/>\n    </visual>\n";
  }
  return text;
}

std::string about(const VehicleOptions& options) {
  return "A vehicle of " + number(options.mass) + " kg with " + std::to_string(options.rotors) +
         " rotors (layout " + options.layout + ") on arms of " + number(options.arm) +
         " m and a thrust to weight of " + number(options.thrust_to_weight) +
         ", all else by scaling laws.";
}

/// Refuses results of the scaling laws that are beyond the ranges of rotor files.
void require_possible(const VehicleOptions& options, const VehicleRotors<double>& rotors) {
  for (const ConstantRow& row : kRotorConstants) {
    const double value = rotors.constants[row.place];
    if (value >= row.least && value <= row.greatest) continue;
    throw Error("a vehicle of " + number(options.mass) + " kg on arms of " + number(options.arm) +
                " m would need rotors with a `" + row.key + "` of " + number(value) + ' ' +
                row.unit + "; allowed: " + format_number(row.least) + " to " +
                format_number(row.greatest) + "; give --mass and --arm that fit one another");
  }
}

}  // namespace

Diagnostics doubts_of_vehicle(const VehicleOptions& options) {
  Diagnostics doubts;
  warn_if_implausible(PlausibilityLimit::kArmByMass, options.arm / std::cbrt(options.mass),
                      "`--arm` (" + number(options.arm) + " m) by the cube root of `--mass` (" +
                          number(options.mass) + " kg)",
                      {{"--mass", options.mass}, {"--arm", options.arm}}, {}, doubts);
  warn_if_implausible(PlausibilityLimit::kThrustToWeight, options.thrust_to_weight,
                      "`--thrust-to-weight`", {}, {}, doubts);
  return doubts;
}

ProjectPart vehicle_part(const VehicleOptions& options) {
  if (!is_identifier(options.name)) {
    throw Error("`" + options.name +
                "` cannot name a vehicle; allowed: letters, digits, '_' and '-', starting with a "
                "letter or '_'");
  }
  if (options.rotors % 2 != 0) {
    throw Error(
        std::to_string(options.rotors) +
        " rotors cannot turn half one way and half the other; give --rotors an even number");
  }
  const double full = options.thrust_to_weight * options.mass * kStandardGravity / options.rotors;
  const VehicleLaws<double, decltype(middle), decltype(is_used)> laws{middle, is_used};
  VehicleRotors<double> rotors{};
  rotors.arm = options.arm;
  laws.make_rotors(std::pow(options.mass, 1.0 / 6.0), full, options.thrust_to_weight, rotors);
  require_possible(options, rotors);
  const double ixx = laws.roll_inertia(options.mass, options.thrust_to_weight, full, options.arm);
  const double iyy = middle(randomization::kPitchInertia) * ixx;
  const auto constant = [&](int place) { return number(rotors.constants[place]); };
  ProjectWords words = {{"@ABOUT@", about(options)},
                        {"@MASS@", number(options.mass)},
                        {"@IXX@", number(ixx)},
                        {"@IYY@", number(iyy)},
                        {"@IZZ@", number(middle(randomization::kYawInertia) * (ixx + iyy))},
                        {"@BODY_RADIUS@", number(options.arm)},
                        {"@HUB_RADIUS@", number(kHubRadius * options.arm)},
                        {"@BODY_HEIGHT@", number(kBodyHeight * options.arm)},
                        {"@ARMS@", arm_lines(options)},
                        {"@THRUST_CONSTANT@", constant(SKYBODY_ROTOR_THRUST_CONSTANT)},
                        {"@MOMENT_CONSTANT@", constant(SKYBODY_ROTOR_MOMENT_CONSTANT)},
                        {"@DRAG_CONSTANT@", constant(SKYBODY_ROTOR_DRAG_CONSTANT)},
                        {"@ROLLING_CONSTANT@", constant(SKYBODY_ROTOR_ROLLING_MOMENT_CONSTANT)},
                        {"@ROTOR_INERTIA@", constant(SKYBODY_ROTOR_INERTIA)},
                        {"@MAX_SPEED@", constant(SKYBODY_ROTOR_MAX_SPEED)},
                        {"@TAU_UP@", constant(SKYBODY_ROTOR_TAU_UP)},
                        {"@TAU_DOWN@", constant(SKYBODY_ROTOR_TAU_DOWN)},
                        {"@ROTORS@", rotor_lines(options)}};
  return {options.name, {"vehicle"}, std::move(words)};
}

std::filesystem::path write_new_vehicle(const VehicleOptions& options) {
  return write_new_project({vehicle_part(options)}, options.name, options.folder);
}

}  // namespace skybody
