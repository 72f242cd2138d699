// Arguments of direct control, shared by Simulation and SimulationPool.
#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/system/arguments.h"
#include "core/simulation/simulation.h"
#include "python/native/errors.h"

namespace skybody::python {

namespace nb = nanobind;

/// The parts of a base's 13 values that teleport() changes. Requires the GIL.
class NewMotion {
 public:
  /// None leaves a part unchanged. @throws TypeError or ValueError unless float64 of that shape
  NewMotion(nb::handle position, nb::handle rotation, nb::handle velocity,
            nb::handle angular_velocity);
  BodyState applied_to(const BodyState& base) const;

 private:
  static std::vector<double> read(nb::handle object, const char* name, int size);
  std::vector<double> position_, rotation_, velocity_, angular_velocity_;
};

/// A name for every body of a world: "quad.base_link".
std::vector<std::string> body_names(const CompiledScenario& compiled);
/// The body of each goal of the task.
std::vector<std::string> goal_bodies(const CompiledScenario& compiled);

/// Takes physics steps in pieces, so that Python can interrupt in between. Calls `advance(piece)`
/// until all are done or it returns false.
template <class Advance>
bool advance_in_pieces(std::int64_t steps, Advance&& advance) {
  constexpr std::int64_t kPiece = 2000;  // some milliseconds of flight
  rethrow_as_argument_error([steps] { check_physics_steps(steps); });
  for (;;) {
    const std::int64_t piece = std::min(steps, kPiece);
    if (!advance(piece)) return false;
    steps -= piece;
    if (steps <= 0) return true;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  }
}

}  // namespace skybody::python
