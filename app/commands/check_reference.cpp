#include "app/commands/check_reference.h"

#include <algorithm>
#include <string>
#include <vector>

#include "app/report/reference_errors.h"
#include "app/report/text_table.h"

namespace skybody {
namespace {

constexpr double kSeconds = 20.0;
/// Fraction of steps from which on a warning is given: a controller may reach its limits briefly
/// while it catches up.
constexpr double kShare = 0.01;

void warn(const CompiledScenario& compiled, const FlownReference& reference,
          const ReferenceError& error, Diagnostics& diagnostics) {
  const RobotUse& robot = compiled.scenario().robots[static_cast<std::size_t>(reference.robot)];
  for (std::size_t k = 0; k < error.limited.size(); ++k) {
    if (!(error.limited[k] > kShare)) continue;
    diagnostics.warning(robot.mark,
                        "robot `" + robot.name +
                            "` does not follow its reference as it is: limits of `" +
                            reference.limits[k].controller + "` cut what it asks for in " +
                            fixed(100.0 * error.limited[k], 0) + " % of a flight (RMS error " +
                            fixed(error.total, 2) +
                            " m); raise its `max_...` parameters, or take a slower `time_scale`");
  }
}

}  // namespace

void warn_of_limited_references(const std::shared_ptr<const CompiledScenario>& compiled,
                                Diagnostics& diagnostics) {
  const std::vector<FlownReference> references = flown_references(*compiled);
  if (std::all_of(references.begin(), references.end(),
                  [](const FlownReference& r) { return r.limits.empty(); })) {
    return;
  }
  Simulation simulation(compiled, 0, 0);
  simulation.reset();
  ReferenceErrors errors(*compiled);
  const std::vector<float> idle(static_cast<std::size_t>(simulation.action_size()), 0.0f);
  while (!simulation.done() && simulation.time() < kSeconds) {
    simulation.step(idle);
    errors.add(simulation);
  }
  const std::vector<ReferenceError> found = errors.errors();
  for (std::size_t k = 0; k < references.size(); ++k) {
    warn(*compiled, references[k], found[k], diagnostics);
  }
}

}  // namespace skybody
