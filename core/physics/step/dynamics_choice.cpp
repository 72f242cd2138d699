#include "core/physics/step/dynamics_choice.h"

#include "core/model/marked_error.h"

namespace skybody {

std::string why_not_tree(const World& world) {
  const std::vector<RobotUse>& robots = world.scenario.robots;
  if (robots.size() != 1) return "has " + std::to_string(robots.size()) + " robots";
  if (!world.scenario.obstacles.empty()) return "has obstacles";
  return "";
}

DynamicsUse chosen_dynamics(const World& world) {
  const Stepping& stepping = world.scenario.stepping;
  if (stepping.dynamics == DynamicsChoice::kSimbody) return DynamicsUse::kSimbody;
  const std::string why_not = why_not_tree(world);
  if (why_not.empty()) return DynamicsUse::kTree;
  if (stepping.dynamics == DynamicsChoice::kAuto) return DynamicsUse::kHandOver;
  throw MarkedError(stepping.dynamics_mark,
                    "`dynamics` is `tree`, but the world " + why_not +
                        ": bodies may touch, and contact other than with the ground is Simbody's; "
                        "use `auto` (tree while nothing is within reach) or `simbody`");
}

}  // namespace skybody
