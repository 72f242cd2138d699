#include "app/reference_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "app/flight_record.h"
#include "app/text_table.h"
#include "core/physics/bodies/default_state.h"

namespace skybody {
namespace {

constexpr const char* kPlugin = "reference";
constexpr int kValues = 4;  // position and yaw

const ParameterValue* given(const PluginUse& use, const std::string& name) {
  for (const ParameterValue& value : use.parameters) {
    if (value.name == name && value.is_given) return &value;
  }
  return nullptr;
}

/// Whether it is the shipped controller, and no plugin of somebody's own of that name.
bool is_reference(const PluginUse& use) {
  const ParameterValue* const kind = given(use, "kind");
  return use.plugin == kPlugin && kind != nullptr && !kind->texts.empty();
}

/// When approach and ramp of a controller `reference` are over [s]. Figures have a ramp by default.
double begin_of(const PluginUse& use) {
  constexpr double kRampOfFigures = 2.0;
  const ParameterValue *approach = given(use, "approach"), *ramp = given(use, "ramp");
  const std::string& kind = given(use, "kind")->texts.at(0);
  const bool has_ramp = kind != "waypoints" && kind != "csv" && kind != "step" && kind != "hold";
  return (approach == nullptr ? 0.0 : approach->numbers.at(0)) + (ramp != nullptr
                                                                      ? ramp->numbers.at(0)
                                                                  : has_ramp ? kRampOfFigures
                                                                             : 0.0);
}

/// Index among the infos of the first value that controller `index` reports.
int info_of_controller(const CompiledScenario& compiled, std::size_t index) {
  int place = value_count(compiled.task().infos);
  for (int kind = 0; kind < SKYBODY_KIND_COUNT; ++kind) {
    const auto& list = compiled.plugins(static_cast<SkybodyKind>(kind));
    for (std::size_t k = 0; k < list.size(); ++k) {
      if (kind == SKYBODY_CONTROLLER && k == index) return place;
      for (const Report& report : list[k].reports) place += report.info.count;
    }
  }
  return place;
}

}  // namespace

double yaw_of(const Quat<double>& rotation) { return 2.0 * std::atan2(rotation.z, rotation.w); }

std::vector<FlownReference> flown_references(const CompiledScenario& compiled) {
  std::vector<FlownReference> found;
  std::size_t index = 0;
  const std::vector<RobotUse>& robots = compiled.scenario().robots;
  for (std::size_t r = 0; r < robots.size(); ++r) {
    for (const PluginUse& use : robots[r].controllers) {
      const std::size_t controller = index++;
      if (!is_reference(use)) continue;
      const int body = compiled.layout().robots[r].first_body;
      found.push_back({given(use, "kind")->texts.at(0), static_cast<int>(r), body,
                       info_of_controller(compiled, controller), begin_of(use)});
    }
  }
  return found;
}

std::vector<double> reference_places(const Simulation& simulation,
                                     const std::vector<FlownReference>& references) {
  const std::span<const float> info = simulation.info();
  std::vector<double> places;
  for (const FlownReference& reference : references) {
    const auto first = info.begin() + reference.info;
    places.insert(places.end(), first, first + kValues);
  }
  return places;
}

ReferenceErrors::ReferenceErrors(const CompiledScenario& compiled)
    : compiled_(compiled), references_(flown_references(compiled)), sums_(references_.size()) {
  for (const FlownReference& reference : references_) {
    hover_speed_.push_back(hover_rotor_speed(compiled.scenario(), reference.robot));
  }
}

void ReferenceErrors::add(const Simulation& simulation) {
  const std::vector<double> places = reference_places(simulation, references_);
  for (std::size_t k = 0; k < references_.size(); ++k) {
    if (simulation.time() < references_[k].begin) continue;
    const BodyState& body = simulation.bodies()[static_cast<std::size_t>(references_[k].body)];
    const double* const place = places.data() + kValues * k;
    const double error[3] = {body.position.x - place[0], body.position.y - place[1],
                             body.position.z - place[2]};
    Sum& sum = sums_[k];
    for (int axis = 0; axis < 3; ++axis) sum.square[axis] += error[axis] * error[axis];
    sum.max = std::max(sum.max, std::hypot(error[0], error[1], error[2]));
    const double yaw = std::remainder(yaw_of(body.rotation) - place[3], 2.0 * std::numbers::pi);
    sum.yaw += yaw * yaw;
    add_effort(simulation, references_[k], sum);
    ++sum.count;
  }
}

void ReferenceErrors::add_effort(const Simulation& simulation, const FlownReference& reference,
                                 Sum& sum) const {
  const auto k = static_cast<std::size_t>(&reference - references_.data());
  const std::vector<Rotor>& rotors =
      compiled_.scenario().robots[static_cast<std::size_t>(reference.robot)].model.rotors;
  const RobotLayout& layout = compiled_.layout().robots[static_cast<std::size_t>(reference.robot)];
  const std::vector<double> speeds = simulation.state("rotor_speed");
  const std::vector<double> commands = simulation.state("rotor_command");
  double cubes = 0.0;
  bool is_saturated = false;
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    const std::size_t place = static_cast<std::size_t>(layout.first_rotor) + i;
    const double share = speeds[place] / hover_speed_[k];
    cubes += share * share * share / static_cast<double>(rotors.size());
    is_saturated =
        is_saturated || commands[place] <= 0.0 || commands[place] >= rotors[i].constants[kMaxSpeed];
  }
  sum.effort += cubes;
  sum.saturated += is_saturated ? 1 : 0;
}

std::vector<ReferenceError> ReferenceErrors::errors() const {
  std::vector<ReferenceError> out;
  for (const Sum& sum : sums_) {
    const auto n = static_cast<double>(sum.count);  // 0 / 0 is NaN: nothing was counted
    ReferenceError& error = out.emplace_back();
    for (int axis = 0; axis < 3; ++axis) error.rms[axis] = std::sqrt(sum.square[axis] / n);
    error.total = std::sqrt((sum.square[0] + sum.square[1] + sum.square[2]) / n);
    error.max = sum.count == 0 ? std::numeric_limits<double>::quiet_NaN() : sum.max;
    error.yaw = std::sqrt(sum.yaw / n);
    error.effort = sum.effort / n;
    error.saturated = static_cast<double>(sum.saturated) / n;
  }
  return out;
}

std::string reference_table(const CompiledScenario& compiled,
                            const std::vector<std::vector<ReferenceError>>& episodes) {
  const std::vector<FlownReference> references = flown_references(compiled);
  if (references.empty()) return "";
  TextTable table({"episode", "reference of", "RMS [cm]", "x [cm]", "y [cm]", "z [cm]", "max [cm]",
                   "yaw RMS [deg]", "effort", "saturated [%]"});
  for (std::size_t e = 0; e < episodes.size(); ++e) {
    for (std::size_t k = 0; k < references.size(); ++k) {
      const ReferenceError& error = episodes[e][k];
      const auto cell = [](double value, int decimals) {
        return std::isnan(value) ? std::string("-") : fixed(value, decimals);
      };
      const auto cm = [&](double metres) { return cell(100.0 * metres, 2); };
      table.add({std::to_string(e + 1), body_name(compiled, references[k].body), cm(error.total),
                 cm(error.rms[0]), cm(error.rms[1]), cm(error.rms[2]), cm(error.max),
                 cell(error.yaw * 180.0 / std::numbers::pi, 2), cell(error.effort, 3),
                 cell(100.0 * error.saturated, 1)});
    }
  }
  return table.to_string() +
         "references: errors after approach and ramp; effort: cubed rotor speeds over those in "
         "hover; saturated: steps in which a rotor's command is at a limit\n";
}

}  // namespace skybody
