// Integrators over the equations of motion, written once for all dynamics.
#pragma once

#include <memory>

#include "core/physics/mechanics.h"

namespace skybody {

/// Advances q and u by dt. Keeps work space only: no memory outlives a step.
class Integrator {
 public:
  virtual ~Integrator() = default;

  /// Between Mechanics::begin_step and end_step. Quaternions come out unnormalised.
  /// @param q, u  coordinates at the start, overwritten with those at the end
  /// @throws std::runtime_error if it gives up
  virtual void advance(Mechanics& mechanics, double* q, double* u) = 0;
};

/// step_rules.h says what these do.
std::unique_ptr<Integrator> make_semi_implicit_euler(const World& world);
std::unique_ptr<Integrator> make_rk4(const World& world);

/// Those of SUNDIALS with the scenario's solver settings: sundials_integrators.cpp.
std::unique_ptr<Integrator> make_cvode(const World& world);
std::unique_ptr<Integrator> make_arkode(const World& world);

/// The one that the scenario asks for.
std::unique_ptr<Integrator> make_integrator(const World& world);

}  // namespace skybody
