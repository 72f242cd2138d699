#include "python/native/direct_control.h"

#include "python/native/arrays.h"

namespace skybody::python {

NewMotion::NewMotion(nb::handle position, nb::handle rotation, nb::handle velocity,
                     nb::handle angular_velocity)
    : position_(read(position, "position", 3)),
      rotation_(read(rotation, "rotation", 4)),
      velocity_(read(velocity, "velocity", 3)),
      angular_velocity_(read(angular_velocity, "angular_velocity", 3)) {}

std::vector<double> NewMotion::read(nb::handle object, const char* name, int size) {
  if (object.is_none()) return {};
  const auto values = read_array<double>(object, name, {size});
  return {values.span().begin(), values.span().end()};
}

BodyState NewMotion::applied_to(const BodyState& base) const {
  BodyState to = base;
  const auto vector = [](const std::vector<double>& v, Vec3<double>& out) {
    if (!v.empty()) out = {v[0], v[1], v[2]};
  };
  vector(position_, to.position);
  vector(velocity_, to.velocity);
  vector(angular_velocity_, to.angular_velocity);
  if (!rotation_.empty()) to.rotation = {rotation_[0], rotation_[1], rotation_[2], rotation_[3]};
  return to;
}

std::vector<std::string> body_names(const CompiledScenario& compiled) {
  std::vector<std::string> names;
  for (const WorldBody& body : compiled.world().bodies) {
    const auto& robots = compiled.scenario().robots;
    names.push_back(robots[static_cast<std::size_t>(body.robot)].name + "." + body.model->name);
  }
  return names;
}

std::vector<std::string> goal_bodies(const CompiledScenario& compiled) {
  const std::vector<std::string> names = body_names(compiled);
  std::vector<std::string> found;
  for (const Goal& goal : compiled.task().task.goals) {
    found.push_back(names[static_cast<std::size_t>(goal.body)]);
  }
  return found;
}

}  // namespace skybody::python
