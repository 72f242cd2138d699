#include "core/physics/step/joint_stops.h"

namespace skybody {

JointStops::JointStops(const World& world) : world_(world) {
  for (std::size_t r = 0; r < world.layout.robots.size(); ++r) {
    const RobotLayout& layout = world.layout.robots[r];
    Robot robot{static_cast<int>(r), {}};
    for (int i = layout.first_body; i < layout.first_body + layout.body_count; ++i) {
      if (has_stops(world.bodies[static_cast<std::size_t>(i)].model->joint)) {
        robot.bodies.push_back(i);
      }
    }
    if (!robot.bodies.empty()) robots_.push_back(std::move(robot));
  }
}

}  // namespace skybody
