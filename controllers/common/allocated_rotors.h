// Selection of the rotors that allocation uses: their pseudo-inverse rows and thrust limits.
//
// A rotor that pushes downwards and cannot reverse is left out. The pseudo-inverse would give it a
// negative thrust in hover; clamping that to 0 loses lift from the other rotors.
#pragma once

#include <string>
#include <vector>

#include "controllers/common/priority.h"
#include "controllers/common/pseudo_inverse.h"
#include "controllers/common/rotor_effects.h"

namespace skybody::control {

/// Selection of rotors for allocation.
enum class RotorSelection {
  kUseful,  ///< all rotors except those that push downwards
  kAll
};

/// Rows of A^T (pseudo_inverse.h): thrust and torque per newton of each rotor.
inline std::vector<double> effect_rows(const View<RotorInfo>& rotors, const BodyInfo& base) {
  std::vector<double> rows;
  for (const RotorInfo& rotor : rotors) {
    const RotorEffect e = effect_of(rotor, base);
    rows.insert(rows.end(), {e.thrust, e.torque.x, e.torque.y, e.torque.z});
  }
  return rows;
}

/// All rotors in their order. Rotors that are left out have rows of 0.
/// @param robot, mode  names, for messages
/// @throws std::runtime_error if thrust and torques are not all reachable
inline std::vector<AllocatedRotor> allocated_rotors(const View<RotorInfo>& rotors,
                                                    const BodyInfo& base, const std::string& robot,
                                                    const std::string& mode,
                                                    RotorSelection taking) {
  constexpr double kRounding = 1e-6;  // tolerance for an axis in the base's xy plane
  std::vector<double> rows;
  std::vector<bool> takes_part;
  for (const RotorInfo& rotor : rotors) {
    const RotorEffect e = effect_of(rotor, base);
    takes_part.push_back(taking == RotorSelection::kAll || e.thrust > -kRounding ||
                         is_reversible(rotor));
    if (takes_part.back()) {
      rows.insert(rows.end(), {e.thrust, e.torque.x, e.torque.y, e.torque.z});
    }
  }
  const bool all_take_part = rows.size() == 4 * takes_part.size();
  const std::vector<double> inverse = PseudoInverse::of(
      rows, robot, mode,
      all_take_part ? "" : "; of rotors that push downwards `allocation: qp` makes use, too");
  constexpr double kNone[4] = {};
  std::vector<AllocatedRotor> allocated;
  std::size_t row = 0;
  for (int i = 0; i < rotors.size(); ++i) {
    const bool takes = takes_part[static_cast<std::size_t>(i)];
    const double* p = takes ? &inverse[4 * row++] : kNone;
    const bool lifts = p[0] * rotors.size() > kRounding;
    allocated.push_back({p[0], p[1], p[2], p[3], lifts ? 1.0 / p[0] : 0.0, least_thrust(rotors[i]),
                         full_thrust(rotors[i]),
                         1.0 / rotors[i].constants[SKYBODY_ROTOR_THRUST_CONSTANT], lifts});
  }
  return allocated;
}

}  // namespace skybody::control
