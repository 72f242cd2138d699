// Integrators that choose their own steps within a physics step: those of SUNDIALS.
#pragma once

#include <functional>
#include <memory>

#include "core/physics/world/world.h"

namespace skybody {

/// dq/dt and du/dt at a time since the start of the step [s].
/// @throws std::runtime_error if the dynamics fails there
using Rates =
    std::function<void(const double* q, const double* u, double time, double* qdot, double* udot)>;

/// Advances q and u by dt. Keeps only work memory: no state outlives a step.
class Integrator {
 public:
  virtual ~Integrator() = default;

  /// Quaternions are not normalised.
  /// @param q, u  coordinates at the start, overwritten with those at the end
  /// @throws std::runtime_error if it fails
  virtual void advance(const Rates& rates, double* q, double* u) = 0;
};

/// The integrator of the scenario, with its solver settings; null for those with fixed steps
/// (integration_rules.h).
std::unique_ptr<Integrator> make_integrator(const World& world);

}  // namespace skybody
