// Ranges of `vehicle`: one range per quantity and preset. Sources: README.md.
#pragma once

#include <cstddef>

namespace skybody::randomization {

/// [low, high]; low > high: not used by the preset.
struct Range {
  double low = 1.0, high = 0.0;
  bool is_used() const { return low <= high; }
};

/// The quantities, in the order of the table below.
enum VehicleQuantity : int {
  kMass,
  kThrustToWeight,
  kArm,
  kSweep,
  kGyration,
  kTorqueToInertia,
  kWeightByTurn,
  kPitchInertia,
  kYawInertia,
  kRotorRadius,
  kThrustCoefficient,
  kMomentByRadius,
  kMomentArm,
  kRotorDrag,
  kRolling,
  kSpinDown,
  kTauUp,
  kTauDownByUp,
  kTauDown,
  kVehicleQuantityCount
};

/// One quantity: its parameter, its allowed values, and the presets' ranges.
struct VehicleRow {
  const char* name;
  const char* unit;
  double least, greatest;
  const char* doc;
  Range scaling, l2f, raptor;
};

/// A Crazyflie's moments of inertia in L2F: 9.4166, 9.6441 and 17.4595e-6 kg m^2.
inline constexpr double kCrazyfliePitch = 1.02416, kCrazyflieYaw = 0.916;
inline constexpr Range kUnused{};

// clang-format off
inline constexpr VehicleRow kVehicleRows[kVehicleQuantityCount] = {
  {"mass", "kg", 1e-3, 1e3, "mass of the vehicle",
   {0.03, 30.0}, {0.02, 5.0}, {0.02, 5.0}},
  {"thrust_to_weight", "", 1.05, 20.0, "thrust of all rotors at their largest speed over the weight under the scenario's gravity",
   {1.5, 4.0}, {1.5, 5.0}, {1.5, 5.0}},
  {"arm", "m", 1e-3, 10.0, "distance of a hub from the centre, at 1 kg: it grows with the cube root of the mass. Its logarithm is normal, with the ends two deviations away",
   {0.114, 0.254}, {0.1025, 0.153}, {0.1025, 0.153}},
  {"sweep", "rad", -0.7, 0.7, "rotation of each arm from its nominal azimuth towards the y axis",
   {-0.12, 0.12}, {0.0, 0.0}, {0.0, 0.0}},
  {"gyration", "", 0.05, 2.0, "radius of gyration about x over the arm",
   {0.4, 0.65}, kUnused, kUnused},
  {"torque_to_inertia", "rad/s^2", 0.1, 1e5, "in place of `gyration`: angular acceleration about x by two rotors at full thrust",
   kUnused, kUnused, {40.0, 1200.0}},
  {"weight_by_turn", "s^2/rad", 1e-5, 10.0, "in place of `gyration`: thrust_to_weight over that acceleration",
   kUnused, {0.001, 0.1}, kUnused},
  {"pitch_inertia", "", 0.1, 10.0, "moment of inertia about y over that about x",
   {0.87, 1.15}, {kCrazyfliePitch, kCrazyfliePitch}, {kCrazyfliePitch, kCrazyfliePitch}},
  {"yaw_inertia", "", 0.05, 0.999, "moment of inertia about z over the sum of the others",
   {0.75, 0.97}, {kCrazyflieYaw, kCrazyflieYaw}, {kCrazyflieYaw, kCrazyflieYaw}},
  {"rotor_radius", "", 0.05, 0.7, "rotor radius over the arm",
   {0.4, 0.62}, {0.4, 0.62}, {0.4, 0.62}},
  {"thrust_coefficient", "", 1e-3, 1.0, "C_T of a propeller: thrust over density, squared revolutions per second and diameter to the fourth",
   {0.08, 0.17}, {0.08, 0.17}, {0.08, 0.17}},
  {"moment_by_radius", "", 1e-4, 2.0, "drag torque over thrust and radius",
   {0.12, 0.27}, kUnused, kUnused},
  {"moment_arm", "m", 1e-5, 1.0, "in place of `moment_by_radius`: drag torque over thrust",
   kUnused, {0.005, 0.05}, {0.005, 0.05}},
  {"rotor_drag", "", 0.0, 10.0, "rotor drag over thrust and advance ratio v / (w R)",
   {0.5, 1.6}, {0.0, 0.0}, {0.0, 0.0}},
  {"rolling_moment", "", 0.0, 1.0, "rolling moment over thrust, radius and advance ratio",
   {0.0, 0.12}, {0.0, 0.0}, {0.0, 0.0}},
  {"spin_down", "s", 0.0, 100.0, "J / (2 k_m w) of a rotor at hover speed, at 1 kg: its time constant of coasting; 0: no inertia",
   {0.04, 0.15}, {0.0, 0.0}, {0.0, 0.0}},
  {"tau_up", "s", 0.0, 10.0, "time constant while speeding up, at 1 kg",
   {0.012, 0.06}, {0.0690909, 0.0690909}, {0.03, 0.10}},
  {"tau_down_by_up", "", 0.0, 100.0, "ratio of the time constant while slowing down to `tau_up`",
   {1.0, 2.0}, kUnused, kUnused},
  {"tau_down", "s", 0.0, 10.0, "in place of `tau_down_by_up`: time constant while slowing down, at 1 kg",
   kUnused, {0.1137374, 0.1137374}, {0.03, 0.30}},
};
// clang-format on

}  // namespace skybody::randomization
