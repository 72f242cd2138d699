// rotors.yaml -> rotors of a model.
//
//     source: the origin of the constants
//     defaults: {direction: ccw, thrust_constant: 1.9e-6, moment_constant: 2.8e-8, max_speed: 2246}
//     rotors:
//       - {name: front_left, link: base_link, position: [0.1, 0.1, 0.02]}
//
// `defaults` has the keys of a rotor and is merged into each. Position and axis are in the link's
// frame; the model stores them in the body's frame. Files may `include` others, like scenarios.
#pragma once

#include <string>

#include "core/io/files/input_budget.h"
#include "core/io/yaml/diagnostics.h"
#include "core/model/robot_model.h"

namespace skybody {

/// Reads `file` and adds its rotors to `model`, whose links must exist already. `text` receives the
/// merged file, for hashes. Returns false after errors, each with its location; `used_at` is the
/// location of the file's name.
bool read_rotors(const std::string& file, const SourceLocation& used_at, RobotModel& model,
                 std::string& text, Diagnostics& diagnostics, InputBudget& budget);

}  // namespace skybody
