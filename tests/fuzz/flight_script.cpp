#include "tests/fuzz/flight_script.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace skybody::fuzz {
namespace {

constexpr std::int64_t kPhysicsSteps = 100;  // of all advance() calls of one script

double value_at(const Values& values, std::size_t k) { return k < values.size() ? values[k] : 0.0; }

/// Maps any number to an index from 0 to n - 1.
std::size_t index_of(const Values& values, std::size_t k, std::size_t n) {
  const double value = std::fabs(value_at(values, k));
  return n > 0 && value < 1e9 ? static_cast<std::size_t>(value) % n : 0;
}

std::vector<float> floats(const Values& values, std::size_t n) {
  std::vector<float> row(n, 0.2f);
  for (std::size_t k = 0; k < std::min(n, values.size()); ++k) {
    row[k] = static_cast<float>(values[k]);
  }
  return row;
}

}  // namespace

/// A command word and its function.
struct FlightScript::Call {
  const char* name;
  void (*act)(FlightScript& script, const Values& values);
};

const std::vector<FlightScript::Call>& FlightScript::calls() {
  using Script = FlightScript&;
  static const std::vector<Call> rows = {
      {"step", [](Script s, const Values& v) { s.step(v); }},
      {"command", [](Script s, const Values& v) { s.command(v); }},
      {"advance", [](Script s, const Values& v) { s.advance(v); }},
      {"evaluate", [](Script s, const Values&) { s.simulation_.evaluate(); }},
      {"teleport", [](Script s, const Values& v) { s.teleport(v); }},
      {"param", [](Script s, const Values& v) { s.set_param(v, false); }},
      {"scale", [](Script s, const Values& v) { s.set_param(v, true); }},
      {"mass", [](Script s, const Values& v) { s.set_mass(v); }},
      {"rotor", [](Script s, const Values& v) { s.set_rotor(v); }},
      {"fork", [](Script s, const Values& v) { s.fork(v); }},
      {"save", [](Script s, const Values&) { s.saved_ = s.simulation_.save(); }},
      {"restore", [](Script s, const Values&) { s.simulation_.restore(s.saved_); }},
      {"reset", [](Script s, const Values&) { s.simulation_.reset(); }},
      {"seed", [](Script s, const Values& v) { s.simulation_.reset(index_of(v, 0, 1000)); }},
      {"randomize", [](Script s, const Values&) { s.simulation_.randomize(); }},
      {"look", [](Script s, const Values&) { s.look(); }},
  };
  return rows;
}

FlightScript::FlightScript(std::shared_ptr<const CompiledScenario> compiled)
    : simulation_(std::move(compiled), 1, 0), budget_(kPhysicsSteps) {
  simulation_.reset();
  saved_ = simulation_.save();
}

std::vector<std::string> FlightScript::names() {
  std::vector<std::string> names;
  for (const Call& call : calls()) names.emplace_back(call.name);
  return names;
}

bool FlightScript::call(const std::string& name, const Values& values) {
  for (const Call& call : calls()) {
    if (name != call.name) continue;
    call.act(*this, values);
    return true;
  }
  return false;
}

const RobotUse& FlightScript::robot(double index) const {
  const auto& robots = simulation_.scenario().robots;
  return robots[index_of({index}, 0, robots.size())];
}

/// Missing values are 0.2; extra values are refused.
void FlightScript::step(const Values& values) {
  const auto size = static_cast<std::size_t>(simulation_.action_size());
  simulation_.step(floats(values, std::max(values.size(), size)));
}

void FlightScript::command(const Values& values) {
  const std::string& name = robot(value_at(values, 0)).name;
  Values row(values.begin() + (values.empty() ? 0 : 1), values.end());
  const auto size = static_cast<std::size_t>(simulation_.command_size(name));
  row.resize(std::max(row.size(), size));
  simulation_.command(name, row);
}

void FlightScript::advance(const Values& values) {
  const double steps = value_at(values, 0);
  if (!(std::fabs(steps) < 1e6)) return;
  const auto count = std::min(static_cast<std::int64_t>(steps), budget_);
  simulation_.advance(count);
  budget_ -= std::max<std::int64_t>(count, 0);
}

void FlightScript::teleport(const Values& values) {
  double base[13] = {0, 0, 1, 1};
  for (std::size_t k = 1; k < std::min<std::size_t>(14, values.size()); ++k) {
    base[k - 1] = values[k];
  }
  BodyState state;
  static_assert(sizeof state == sizeof base);
  std::memcpy(reinterpret_cast<double*>(&state), base, sizeof base);
  simulation_.teleport(robot(value_at(values, 0)).name, state);
}

void FlightScript::set_param(const Values& values, bool is_factor) {
  const std::vector<EnvParam>& params = simulation_.compiled().layout().param_info;
  if (params.empty()) return;
  const std::string& path = params[index_of(values, 0, params.size())].path;
  simulation_.set_param(path, value_at(values, 1) * (is_factor ? simulation_.param(path) : 1.0));
}

void FlightScript::set_mass(const Values& values) {
  const RobotUse& use = robot(value_at(values, 0));
  const std::string& link = use.model.links[index_of(values, 1, use.model.links.size())].name;
  MassProperties mass = simulation_.mass_properties(use.name, link);
  double* const places[] = {&mass.mass,       &mass.com.x,      &mass.com.y,      &mass.com.z,
                            &mass.inertia.xx, &mass.inertia.yy, &mass.inertia.zz, &mass.inertia.xy,
                            &mass.inertia.xz, &mass.inertia.yz};
  for (std::size_t k = 0; k < std::size(places) && k + 2 < values.size(); ++k) {
    *places[k] = values[k + 2];
  }
  simulation_.set_mass_properties(use.name, link, mass);
}

void FlightScript::set_rotor(const Values& values) {
  constexpr const char* kNames[] = {"thrust_constant", "moment_constant", "max_speed",    "tau_up",
                                    "tau_down",        "inertia",         "drag_constant"};
  const auto rotor = static_cast<int>(index_of(values, 1, 7));
  simulation_.set_rotor_parameter(robot(value_at(values, 0)).name, rotor,
                                  kNames[index_of(values, 2, std::size(kNames))],
                                  value_at(values, 3));
}

/// Continues with a copy.
void FlightScript::fork(const Values& values) {
  Simulation copy = simulation_.fork(index_of(values, 0, 2) == 1);
  simulation_ = std::move(copy);
}

/// Calls all query functions. The dynamics may report that a result is not available.
void FlightScript::look() {
  simulation_.bodies();
  simulation_.goals();
  simulation_.sensors();
  simulation_.contacts();
  simulation_.accelerations();
}

}  // namespace skybody::fuzz
