// Direct control: commands in physical units, physics steps without a task, and changes of state
// and parameters.
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "core/base/simd/fp_environment.h"
#include "core/base/system/arguments.h"
#include "core/base/system/error.h"
#include "core/env/param_access.h"
#include "core/physics/bodies/checked_mass.h"
#include "core/simulation/simulation.h"
#include "core/simulation/simulation_data.h"

namespace skybody {
namespace {

void demand_finite(const std::string& what, std::span<const double> values) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k])) continue;
    std::ostringstream message;
    message << what << " value " << k << " is " << values[k] << "; it must be a finite number";
    throw Error(message.str());
  }
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

int Simulation::robot_index(const std::string& name) const {
  const auto& robots = scenario().robots;
  std::vector<std::string> known;
  for (std::size_t r = 0; r < robots.size(); ++r) {
    if (robots[r].name == name || (name.empty() && robots.size() == 1)) return static_cast<int>(r);
    known.push_back(robots[r].name);
  }
  throw Error("no robot `" + name + "`: there are " + joined(known));
}

int Simulation::body_index(const std::string& robot, const std::string& link) const {
  const auto r = static_cast<std::size_t>(robot_index(robot));
  const RobotModel& model = scenario().robots[r].model;
  const int index = model.find_link(link);
  if (index < 0) {
    std::vector<std::string> known;
    for (const Link& l : model.links) known.push_back(l.name);
    throw Error("robot `" + scenario().robots[r].name + "` has no link `" + link + "`: there are " +
                joined(known));
  }
  return compiled_->layout().robots[r].first_body +
         model.links[static_cast<std::size_t>(index)].body;
}

void Simulation::demand_started(const char* call) const {
  if (!data_->started) {
    throw Error(std::string(call) + "() before reset(): begin an episode first");
  }
}

int Simulation::command_size(const std::string& robot) const {
  const auto r = static_cast<std::size_t>(robot_index(robot));
  const int size = compiled_->model().commands_of(static_cast<int>(r)).size;
  if (size == 0) {
    const bool is_fed = !scenario().robots[r].controllers.empty();
    throw Error("robot `" + scenario().robots[r].name + "` takes no commands: " +
                (is_fed ? "a team's controllers command it; command the team's first robot"
                        : "give it `controllers` in the scenario"));
  }
  return size;
}

void Simulation::command(const std::string& robot, std::span<const double> values) {
  demand_started("command");
  const int size = command_size(robot);
  const auto r = static_cast<std::size_t>(robot_index(robot));
  check_values("command", values.size(), 1, size);
  demand_finite("command", values);
  data_->group.scatter(0, compiled_->model().commands_of(static_cast<int>(r)), values.data());
}

bool Simulation::advance(std::int64_t physics_steps) {
  demand_started("advance");
  check_physics_steps(physics_steps);
  // The episode ended in an earlier call: split calls give the same result as one.
  if ((data_->status & kBadState) != 0) return false;
  apply_requests();
  const bool through = compiled_->advance(data_->group, *data_->work, 1u, physics_steps) != 0;
  data_->status = data_->group.bits(kStatus)[0];
  return through;
}

void Simulation::evaluate() {
  demand_started("evaluate");
  const FpEnvironment guard;
  compiled_->evaluate(data_->group, *data_->work, 1u, data_->rows());
  add_to_hash();
}

Accelerations Simulation::accelerations() const {
  const StateLayout& layout = compiled_->layout();
  Accelerations out;
  out.udot.resize(static_cast<std::size_t>(layout.u.size));
  try {
    compiled_->accelerations(data_->group, *data_->work, 0, out.udot.data());
  } catch (const std::runtime_error& error) {
    throw Error(std::string("the dynamics has no accelerations at this state: ") + error.what());
  }
  const StateGroup& group = data_->group;
  out.bodies = body_accelerations(make_tree(compiled_->world()), group.reals(layout.q),
                                  group.reals(layout.u), out.udot.data());
  return out;
}

std::vector<Contact> Simulation::contacts() const {
  try {
    return compiled_->contacts(data_->group, *data_->work, 0);
  } catch (const std::runtime_error& error) {
    throw Error(std::string("the dynamics has no contacts at this state: ") + error.what());
  }
}

void Simulation::teleport(const std::string& robot, const BodyState& base) {
  demand_started("teleport");
  const auto r = static_cast<std::size_t>(robot_index(robot));
  if (scenario().robots[r].model.fixed_base) {
    throw Error("robot `" + scenario().robots[r].name +
                "` has a fixed base: its pose is that of the scenario");
  }
  const auto* values = reinterpret_cast<const double*>(&base);
  demand_finite("teleport", {values, 13});
  const Quat<double>& turn = base.rotation;
  const double largest =
      std::max({std::fabs(turn.w), std::fabs(turn.x), std::fabs(turn.y), std::fabs(turn.z)});
  if (!(largest > 1e-100)) throw Error("teleport() with a zero quaternion: it has no direction");
  // Scale first: the square of a large finite number need not be finite.
  const Quat<double> unit = normalized(
      Quat<double>{turn.w / largest, turn.x / largest, turn.y / largest, turn.z / largest});
  const StateLayout& layout = compiled_->layout();
  const RobotLayout& place = layout.robots[r];
  const std::array<double, 7> q{base.position.x, base.position.y, base.position.z, unit.w,
                                unit.x,          unit.y,          unit.z};
  const std::array<double, 6> u{base.velocity.x,         base.velocity.y,
                                base.velocity.z,         base.angular_velocity.x,
                                base.angular_velocity.y, base.angular_velocity.z};
  data_->group.scatter(0, {layout.q.offset + place.first_q, 7}, q.data());
  data_->group.scatter(0, {layout.u.offset + place.first_u, 6}, u.data());
}

MassProperties Simulation::mass_properties(const std::string& robot,
                                           const std::string& link) const {
  const StateLayout& layout = compiled_->layout();
  const int first = layout.body_params[static_cast<std::size_t>(body_index(robot, link))];
  std::array<double, kBodyParamCount> p;
  data_->group.gather(0, {layout.params.offset + first, kBodyParamCount}, p.data());
  return skybody::mass_properties(p.data());
}

void Simulation::set_mass_properties(const std::string& robot, const std::string& link,
                                     const MassProperties& mass) {
  const int body = body_index(robot, link);
  const std::array<double, kBodyParamCount> p = body_constants(mass);
  demand_finite("mass property", p);
  const auto& model = *compiled_->world().bodies[static_cast<std::size_t>(body)].model;
  checked_mass(model.name, p.data());
  const StateLayout& layout = compiled_->layout();
  const int first = layout.body_params[static_cast<std::size_t>(body)];
  data_->group.scatter(0, {layout.params.offset + first, kBodyParamCount}, p.data());
}

std::string Simulation::rotor_path(const std::string& robot, int rotor,
                                   const std::string& name) const {
  const auto r = static_cast<std::size_t>(robot_index(robot));
  const int count = compiled_->layout().robots[r].rotor_count;
  if (rotor < 0 || rotor >= count) {
    throw Error("robot `" + scenario().robots[r].name + "` has no rotor " + std::to_string(rotor) +
                ": it has " + std::to_string(count) +
                ", counted from 0 in the order of the rotors file");
  }
  return "robots." + scenario().robots[r].name + ".rotors[" + std::to_string(rotor) + "]." + name;
}

double Simulation::rotor_parameter(const std::string& robot, int rotor,
                                   const std::string& name) const {
  return param(rotor_path(robot, rotor, name));
}

void Simulation::set_rotor_parameter(const std::string& robot, int rotor, const std::string& name,
                                     double value) {
  set_param(rotor_path(robot, rotor, name), value);
}

}  // namespace skybody
