#include "core/env/check_declarations.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_set>

#include "core/base/plugin_kind.h"
#include "core/base/system/error.h"
#include "core/env/controller_chains.h"

namespace skybody {
namespace {

[[noreturn]] void refuse(const PluginInstance& plugin, const std::string& what) {
  throw Error("plugin `" + plugin.plugin + "` " + what + "; this is a mistake in the plugin");
}

bool is_signal(int signal) { return signal >= 0 && signal < SKYBODY_SIGNAL_COUNT; }

/// Checks that a signal has one of the sizes in its row of SKYBODY_SIGNALS.
void check_size(const PluginInstance& p, int signal, int count, const char* verb) {
  struct Size {
    int least, most;
  };
  static constexpr Size kSizes[] = {
#define SKYBODY_ROW(symbol, type, word, least, most, doc) {least, most},
      SKYBODY_SIGNALS(SKYBODY_ROW)
#undef SKYBODY_ROW
  };
  const Size& size = kSizes[signal];
  if (size.least == 0 || count == size.least || count == size.most) return;
  if (size.most == 0 && count > 0 && count % size.least == 0) return;
  const std::string others = size.most == 0            ? " a point"
                             : size.least == size.most ? ""
                                                       : " or " + std::to_string(size.most);
  refuse(p, std::string(verb) + " " + signal_name(signal) + " with " + std::to_string(count) +
                " values; it has " + std::to_string(size.least) + others);
}

void check_controller(const PluginInstance& p) {
  const bool is_none = p.controller.input_signal == SKYBODY_NONE;
  if (!is_signal(p.controller.input_signal) || p.controller.low.empty() != is_none) {
    refuse(p, "declares no input that there is");
  }
  if (p.controller.input_calls > 1)
    refuse(p, "declares its input " + std::to_string(p.controller.input_calls) + " times");
  check_size(p, p.controller.input_signal, p.controller.input_count(), "takes");
  if (p.controller.outputs.empty()) refuse(p, "declares no output that there is");
  for (std::size_t i = 0; i < p.controller.outputs.size(); ++i) {
    const PluginOutput& output = p.controller.outputs[i];
    if (!is_signal(output.signal) || output.signal == SKYBODY_NONE || output.count < 1) {
      refuse(p, "declares no output that there is");
    }
    if (!p.controller.serves(output.robot)) {
      refuse(p, "declares an output to robot " + std::to_string(output.robot) +
                    ", which it does not serve");
    }
    check_size(p, output.signal, output.count, "gives");
    for (std::size_t k = 0; k < i; ++k) {
      if (p.controller.outputs[k].signal != output.signal ||
          p.controller.outputs[k].robot != output.robot)
        continue;
      refuse(p, std::string("declares its output ") + signal_name(output.signal) +
                    " twice; one call of output() names all of its values");
    }
  }
  for (std::size_t k = 0; k < p.controller.low.size(); ++k) {
    if (!std::isfinite(p.controller.low[k]) || !std::isfinite(p.controller.high[k]) ||
        p.controller.low[k] > p.controller.high[k]) {
      refuse(p, "declares an input range that is not finite or upside down, component " +
                    std::to_string(k));
    }
  }
}

constexpr double kMostImageBytes = 1 << 28;

/// Checks an image's type, extents and size. Only sensors may declare images.
void check_image(const PluginInstance& p, const Channel& c) {
  const std::string what = "declares image `" + c.name + "` ";
  if (p.kind != SKYBODY_SENSOR) refuse(p, what + "and is no sensor");
  if (static_cast<std::size_t>(c.type) >= kColumnTypes.size()) {
    refuse(p,
           what + "of type " + std::to_string(static_cast<int>(c.type)) + ", which there is not");
  }
  double count = 1.0;
  for (const int extent : c.shape) {
    if (extent < 1) refuse(p, what + "with an extent of " + std::to_string(extent));
    count *= extent;
  }
  if (count * info_of(c.type).bytes > kMostImageBytes) refuse(p, what + "of more than 256 MiB");
  if (count != c.count) {
    refuse(p, what + "with " + std::to_string(c.count) + " values, not the product of its extents");
  }
}

void check_channel(const PluginInstance& p, const Channel& c, int robots) {
  if (c.is_image()) check_image(p, c);
  if (c.count < 1 || !(c.low <= c.high)) {
    refuse(p, "declares channel `" + c.name + "` with " + std::to_string(c.count) +
                  " values or bounds upside down");
  }
  if (c.robot < -1 || c.robot >= robots) {
    refuse(p, "declares channel `" + c.name + "` of robot " + std::to_string(c.robot) + " of " +
                  std::to_string(robots));
  }
}

void check_joint(const PluginInstance& p, const JointDrive& j, const Topology& topology) {
  if (j.body < 0 || j.body >= static_cast<int>(topology.bodies.size())) {
    refuse(p, "drives the joint of body " + std::to_string(j.body) + " of " +
                  std::to_string(topology.bodies.size()));
  }
  const WorldBody& body = topology.bodies[static_cast<std::size_t>(j.body)];
  const JointType type = body.model->joint.type;
  const bool has_axis =
      type == JointType::kPin || type == JointType::kSlider || type == JointType::kUniversal;
  const std::string name = "drives joint `" + body.model->joint.name + "`, ";
  if (!has_axis || j.coordinate < 0 || j.coordinate >= velocity_size(type)) {
    refuse(p, name + "coordinate " + std::to_string(j.coordinate) +
                  "; allowed: coordinates of pin, slider and universal joints");
  }
  if (!p.controller.serves(body.robot)) refuse(p, name + "which is another robot's");
  const bool is_sound = j.stiffness >= 0.0 && j.damping >= 0.0 && j.effort_limit > 0.0 &&
                        j.tau >= 0.0 && std::isfinite(j.stiffness) && std::isfinite(j.damping) &&
                        std::isfinite(j.tau) && j.low <= j.high;
  if (!is_sound || j.mode < JointMode::kPosition || j.mode > JointMode::kEffort) {
    refuse(p, name + "with a mode, stiffness, damping, limit, lag or range that there is not");
  }
}

/// Checks that the requested bodies, obstacles and joints exist.
void check_asked(const PluginInstance& p, const Topology& topology) {
  const auto bodies = static_cast<int>(topology.bodies.size());
  const auto obstacles = static_cast<int>(topology.scenario.obstacles.size());
  for (const ContactPair& pair : p.contact_pairs) {
    const int others = pair.partner == SKYBODY_OTHER_BODY ? bodies
                       : pair.partner == SKYBODY_OBSTACLE ? obstacles
                                                          : 1;
    const bool is_there = pair.partner >= 0 && pair.partner < SKYBODY_PARTNER_COUNT &&
                          pair.body >= 0 && pair.body < bodies && pair.other >= 0 &&
                          pair.other < others;
    if (is_there) continue;
    refuse(p, "asks for the contact of body " + std::to_string(pair.body) + " with " +
                  std::to_string(pair.other) + ", which there is not");
  }
  for (const int body : p.joint_reactions) {
    if (body >= 0 && body < bodies) continue;
    refuse(p, "asks for the reaction of the joint of body " + std::to_string(body) + " of " +
                  std::to_string(bodies));
  }
}

/// Checks that values of effects for sensors lie in the buffer, and belong to robots.
void check_offers(const PluginInstance& p, int robots) {
  for (const Offer& offer : p.effect.offers) {
    const bool is_inside =
        offer.count > 0 && offer.word >= 0 && offer.word + offer.count <= p.memory.buffer_words;
    if (is_inside && offer.robot >= 0 && offer.robot < robots) continue;
    refuse(p,
           "offers `" + offer.name + "` of a robot or of words of its buffer that there are not");
  }
  for (const OfferRequest& request : p.sensor.requests) {
    if (request.count > 0 && request.robot >= 0 && request.robot < robots) continue;
    refuse(p, "asks for `" + request.name + "` of a robot that there is not");
  }
}

/// Checks a task's own action: in robot order, with finite ranges, and with a process() that
/// converts it to commands.
void check_actions(const PluginInstance& p, int robots) {
  int robot = 0;
  for (const Channel& c : p.task.actions) {
    if (c.robot < robot || c.robot >= robots || c.count < 1 || !std::isfinite(c.low) ||
        !std::isfinite(c.high) || c.low > c.high) {
      refuse(p, "declares action `" + c.name +
                    "` out of robot order, without values or with a range that is not finite");
    }
    robot = c.robot;
  }
  if (!p.task.actions.empty() && p.kernels.process == nullptr) {
    refuse(p, "declares an action of its own, but has no process() that makes commands of it");
  }
}

/// Rejects declarations that the plugin's kind may not make.
void check_kind(const PluginInstance& p) {
  const auto demand = [&](bool is_declared, bool may, const char* what) {
    if (is_declared && !may) {
      refuse(p, std::string("declares ") + what + ", which no " + kind_name(p.kind) + " does");
    }
  };
  const bool is_task = p.kind == SKYBODY_TASK, is_controller = p.kind == SKYBODY_CONTROLLER;
  const bool holds =
      std::any_of(p.effect.holds.begin(), p.effect.holds.end(), [](bool held) { return held; });
  demand(p.controller.input_calls > 0 || !p.controller.outputs.empty(), is_controller,
         "an input or output");
  demand(!p.controller.sites.empty() || !p.controller.joints.empty(), is_controller,
         "a site or joint");
  demand(!p.channels.empty(), is_task || p.kind == SKYBODY_SENSOR, "a channel");
  demand(holds, p.kind == SKYBODY_EFFECT, "a held input");
  demand(p.effect.is_steady, p.kind == SKYBODY_EFFECT, "that it is steady");
  demand(!p.effect.offers.empty(), p.kind == SKYBODY_EFFECT, "values for sensors");
  demand(!p.sensor.requests.empty(), p.kind == SKYBODY_SENSOR, "that it reads values of an effect");
  demand(!p.writes.empty(), is_task || p.kind == SKYBODY_RANDOMIZER, "what it writes");
  demand(p.period > 0, p.kind != SKYBODY_RANDOMIZER, "a period");
  demand(!p.reports.empty(), !is_task, "a report (a task has info)");
  demand(!p.task.infos.empty() || !p.task.goals.empty() || p.task.robot_rewards, is_task,
         "info, goals or robots' rewards");
  demand(!p.task.actions.empty() || p.task.interpolates, is_task, "an action");
}

void check_reports(const PluginInstance& p) {
  std::unordered_set<std::string> names;
  for (const Report& report : p.reports) {
    if (!names.insert(report.info.name).second) {
      refuse(p, "reports `" + report.info.name + "` twice");
    }
  }
  for (const Report& report : p.reports) {
    if (report.info.count < 1 || report.word < 0 ||
        report.word + report.info.count > p.memory.buffer_words) {
      refuse(p, "reports `" + report.info.name + "` from words " + std::to_string(report.word) +
                    ".. of a buffer of " + std::to_string(p.memory.buffer_words));
    }
  }
}

void check_names(const PluginInstance& p, const std::vector<Channel>& channels) {
  std::unordered_set<std::string> names;
  for (const Channel& c : channels) {
    if (!names.insert(c.name).second) refuse(p, "declares two channels `" + c.name + "`");
  }
}

/// Rejects a task without any observation for a policy.
void check_observation(const PluginInstance& p) {
  const bool sees = std::any_of(p.channels.begin(), p.channels.end(),
                                [](const Channel& c) { return !c.privileged; });
  if (!sees) refuse(p, "declares no observation for a policy");
}

/// For each value of the observation, whether a policy sees it.
std::vector<bool> values_of_policy(const PluginInstance& p) {
  std::vector<bool> values;
  for (const Channel& c : p.channels) {
    if (!c.is_image())
      values.insert(values.end(), static_cast<std::size_t>(c.count), !c.privileged);
  }
  return values;
}

void check_repeats(const PluginInstance& p) {
  if (p.task.repeats.empty()) return;
  if (p.kind != SKYBODY_TASK) refuse(p, "repeats values of an observation, which tasks alone have");
  const std::vector<bool> is_of_policy = values_of_policy(p);
  const int size = static_cast<int>(is_of_policy.size());
  std::vector<bool> is_copy(is_of_policy.size(), false);
  const auto each_value = [size](int first, int count, const auto& f) {
    const bool is_inside = first >= 0 && count >= 1 && first <= size - count;
    for (int k = first; is_inside && k < first + count; ++k) {
      if (!f(static_cast<std::size_t>(k))) return false;
    }
    return is_inside;
  };
  const auto refuse_copy = [&p](const ValueCopy& copy, const std::string& why) {
    refuse(p, "repeats " + std::to_string(copy.count) + " values from " +
                  std::to_string(copy.from) + " on at " + std::to_string(copy.to) + ", " + why);
  };
  for (const ValueCopy& copy : p.task.repeats) {
    const bool is_new = each_value(copy.to, copy.count, [&](std::size_t k) {
      const bool may = is_of_policy[k] && !is_copy[k];
      is_copy[k] = true;
      return may;
    });
    if (!is_new) refuse_copy(copy, "which are no values that a policy sees, or repeat others");
  }
  for (const ValueCopy& copy : p.task.repeats) {
    const bool is_source = each_value(
        copy.from, copy.count, [&](std::size_t k) { return is_of_policy[k] && !is_copy[k]; });
    if (!is_source) refuse_copy(copy, "of which some repeat others, or no policy sees them");
  }
}

void check_goals(const PluginInstance& p, int bodies, int robots) {
  for (const Goal& goal : p.task.goals) {
    if (goal.robot < 0 || goal.robot >= robots || goal.body < 0 || goal.body >= bodies) {
      refuse(p, "declares a goal about robot " + std::to_string(goal.robot) + ", body " +
                    std::to_string(goal.body) + ", which there is not");
    }
  }
  if (!p.task.goals.empty() && p.kernels.goal == nullptr) {
    refuse(p, "declares a goal, but has no goal() that says where it is");
  }
  if (p.task.goals.empty() && p.kernels.goal_motion != nullptr) {
    refuse(p, "says by goal_motion() how goals move, but declares none by Setup::goal()");
  }
}

}  // namespace

void check_declarations(const Topology& topology, const StateLayout& layout,
                        const PluginInstance& p) {
  const auto bodies = static_cast<int>(topology.bodies.size());
  const auto robots = static_cast<int>(topology.scenario.robots.size());
  const auto params = static_cast<int>(layout.param_info.size());
  check_kind(p);
  if (p.kind == SKYBODY_CONTROLLER) check_controller(p);
  if (p.memory.buffer_words < 0)
    refuse(p, "asks for a buffer of " + std::to_string(p.memory.buffer_words) + " words");
  for (const WrenchSite& site : p.controller.sites) {
    if (site.body < 0 || site.body >= bodies) {
      refuse(p, "names body " + std::to_string(site.body) + " of " + std::to_string(bodies));
    }
  }
  check_goals(p, bodies, robots);
  if (p.kind == SKYBODY_TASK && !p.writes.empty() && p.kernels.randomize == nullptr) {
    refuse(p, "announces that it draws parameters, but has no randomize() that does");
  }
  for (const JointDrive& joint : p.controller.joints) check_joint(p, joint, topology);
  check_asked(p, topology);
  check_offers(p, static_cast<int>(topology.scenario.robots.size()));
  check_actions(p, robots);
  check_names(p, p.task.actions);
  check_reports(p);
  if (p.memory.scratch < 0)
    refuse(p, "asks for " + std::to_string(p.memory.scratch) + " values of scratch");
  if (p.effect.is_steady && p.period > 0) {
    refuse(p,
           "declares a period and that it is steady: what is steady is called where parameters "
           "change");
  }
  if (p.memory.memo < 0) refuse(p, "asks for " + std::to_string(p.memory.memo) + " values of memo");
  if (p.kind == SKYBODY_TASK && p.period > 0 &&
      topology.scenario.stepping.action_repeat % p.period != 0) {
    refuse(p, "wants process() every " + std::to_string(p.period) +
                  " physics steps, which do not divide action_repeat " +
                  std::to_string(topology.scenario.stepping.action_repeat));
  }
  for (const int param : p.writes) {
    if (param < 0 || param >= params) {
      refuse(p, "writes parameter " + std::to_string(param) + " of " + std::to_string(params));
    }
  }
  for (const Channel& c : p.channels) check_channel(p, c, robots);
  for (const Channel& c : p.task.infos) check_channel(p, c, robots);
  check_names(p, p.channels);
  check_names(p, p.task.infos);
  check_repeats(p);
  if (p.kind == SKYBODY_SENSOR && p.channels.empty()) refuse(p, "declares no output");
  if (p.kind == SKYBODY_TASK) check_observation(p);
}

}  // namespace skybody
