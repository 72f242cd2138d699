// Replaces Simbody and SUNDIALS where the tree engine is compiled without them.
#include "core/base/system/error.h"
#include "core/physics/simbody/dynamics.h"
#include "core/physics/step/integration_rules.h"
#include "core/physics/step/integrator.h"

namespace skybody {

std::unique_ptr<Dynamics> make_simbody_dynamics(const World&, const double*) {
  throw Error("this program was built without Simbody: only the tree's dynamics are available");
}

void check_simbody(const World& world) { make_simbody_dynamics(world, nullptr); }

std::unique_ptr<Integrator> make_integrator(const World& world) {
  if (!is_error_controlled(world.scenario.stepping.integrator)) return nullptr;
  throw Error("this program was built without SUNDIALS: only fixed-step integrators are available");
}

}  // namespace skybody
