#include "app/report/reference_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "app/report/flight_record.h"
#include "app/report/text_table.h"
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

/// Whether it is the shipped controller, and not a user's plugin of that name.
bool is_reference(const PluginUse& use) {
  const ParameterValue* const kind = given(use, "kind");
  return use.plugin == kPlugin && kind != nullptr && !kind->texts.empty();
}

/// Time at which approach and ramp of a controller `reference` are over [s]. Figures have a ramp by
/// default.
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

/// Calls visit(controller, report, place) for all reports of controllers, with their indices among
/// the infos.
template <class Visit>
void each_report(const CompiledScenario& compiled, const Visit& visit) {
  int place = value_count(compiled.task().task.infos);
  for (int kind = 0; kind < SKYBODY_KIND_COUNT; ++kind) {
    const auto& list = compiled.plugins(static_cast<SkybodyKind>(kind));
    for (std::size_t k = 0; k < list.size(); ++k) {
      for (const Report& report : list[k].reports) {
        if (kind == SKYBODY_CONTROLLER) visit(k, report, place);
        place += report.info.count;
      }
    }
  }
}

/// Name of a controller's report about its limits (controllers/common/limit_report.h).
constexpr const char* kLimited = "limited";

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
      FlownReference& flown = found.emplace_back();
      flown.kind = given(use, "kind")->texts.at(0);
      flown.robot = static_cast<int>(r);
      flown.body = compiled.layout().robots[r].first_body;
      flown.begin = begin_of(use);
      const std::size_t first =
          controller - static_cast<std::size_t>(&use - robots[r].controllers.data());
      const std::size_t end = first + robots[r].controllers.size();
      bool is_first = true;
      each_report(compiled, [&](std::size_t k, const Report& report, int place) {
        if (k == controller && is_first) {
          flown.info = place;
          is_first = false;
        }
        if (k < first || k >= end || report.info.name != kLimited) return;
        flown.limits.push_back({robots[r].controllers[k - first].instance, place});
      });
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
    const std::vector<LawLimit>& limits = references_[k].limits;
    sum.limited.resize(limits.size());
    for (std::size_t i = 0; i < limits.size(); ++i) {
      sum.limited[i] += simulation.info()[static_cast<std::size_t>(limits[i].info)] > 0.0f ? 1 : 0;
    }
    ++sum.count;
  }
}

void ReferenceErrors::add_effort(const Simulation& simulation, const FlownReference& reference,
                                 Sum& sum) const {
  const auto k = static_cast<std::size_t>(&reference - references_.data());
  const RobotModel& model =
      compiled_.scenario().robots[static_cast<std::size_t>(reference.robot)].model;
  const std::vector<Rotor>& rotors = model.rotors;
  const RobotLayout& layout = compiled_.layout().robots[static_cast<std::size_t>(reference.robot)];
  const std::vector<double> speeds = simulation.state("rotor_speed");
  const std::vector<double> commands = simulation.state("rotor_command");
  double cubes = 0.0;
  bool is_saturated = false;
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    const std::size_t place = static_cast<std::size_t>(layout.first_rotor) + i;
    const double share = speeds[place] / hover_speed_[k];
    cubes += std::abs(share * share * share) / static_cast<double>(rotors.size());
    // A rotor that need not produce thrust in hover may stand still.
    const bool may_rest = !rotors[i].is_reversible() && lift_of(model, rotors[i]) == 0.0;
    is_saturated = is_saturated || (!may_rest && commands[place] <= rotors[i].min_speed) ||
                   commands[place] >= rotors[i].constants[kMaxSpeed];
  }
  sum.effort += cubes;
  sum.saturated += is_saturated ? 1 : 0;
}

std::vector<ReferenceError> ReferenceErrors::errors() const {
  std::vector<ReferenceError> out;
  for (const Sum& sum : sums_) {
    const auto n = static_cast<double>(sum.count);  // 0 / 0 is NaN: no samples
    ReferenceError& error = out.emplace_back();
    for (int axis = 0; axis < 3; ++axis) error.rms[axis] = std::sqrt(sum.square[axis] / n);
    error.total = std::sqrt((sum.square[0] + sum.square[1] + sum.square[2]) / n);
    error.max = sum.count == 0 ? std::numeric_limits<double>::quiet_NaN() : sum.max;
    error.yaw = std::sqrt(sum.yaw / n);
    error.effort = sum.effort / n;
    error.saturated = static_cast<double>(sum.saturated) / n;
    for (const std::size_t steps : sum.limited) {
      error.limited.push_back(static_cast<double>(steps) / n);
    }
  }
  return out;
}

namespace {

/// "0.0", or "41.3 (position)" for the controller whose limits are active most often.
std::string limited_text(const FlownReference& reference, const ReferenceError& error) {
  if (error.limited.empty() || std::isnan(error.total)) return "-";
  const auto most = std::max_element(error.limited.begin(), error.limited.end());
  const std::string share = fixed(100.0 * *most, 1);
  if (!(*most > 0.0)) return share;
  const auto k = static_cast<std::size_t>(most - error.limited.begin());
  return share + " (" + reference.limits[k].controller + ")";
}

}  // namespace

std::string reference_table(const CompiledScenario& compiled,
                            const std::vector<std::vector<ReferenceError>>& episodes) {
  const std::vector<FlownReference> references = flown_references(compiled);
  if (references.empty()) return "";
  TextTable table({"episode", "reference of", "RMS [cm]", "x [cm]", "y [cm]", "z [cm]", "max [cm]",
                   "yaw RMS [deg]", "effort", "saturated [%]", "limited [%]"});
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
                 cell(100.0 * error.saturated, 1), limited_text(references[k], error)});
    }
  }
  return table.to_string() +
         "references: errors after approach and ramp; effort: cubed rotor speeds relative to "
         "hover; saturated: steps with a rotor's command at a limit; limited: steps with a "
         "controller's output cut by its own limits\n";
}

}  // namespace skybody
