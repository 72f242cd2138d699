#include "core/env/check_declarations.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_set>

#include "core/base/error.h"

namespace skybody {
namespace {

[[noreturn]] void refuse(const PluginInstance& plugin, const std::string& what) {
  throw Error("plugin `" + plugin.plugin + "` " + what + "; this is a mistake in the plugin");
}

bool is_signal(int signal) { return signal >= 0 && signal < SKYBODY_SIGNAL_COUNT; }

void check_controller(const PluginInstance& p) {
  if (!is_signal(p.input_signal) || p.low.empty()) refuse(p, "declares no input that there is");
  if (!is_signal(p.output_signal) || p.output_count < 1) {
    refuse(p, "declares no output that there is");
  }
  for (std::size_t k = 0; k < p.low.size(); ++k) {
    if (!std::isfinite(p.low[k]) || !std::isfinite(p.high[k]) || p.low[k] > p.high[k]) {
      refuse(p, "declares an input range that is not finite or upside down, component " +
                    std::to_string(k));
    }
  }
}

constexpr double kMostImageBytes = 1 << 28;

/// An image's type, extents and size. Only sensors give images.
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

void check_names(const PluginInstance& p, const std::vector<Channel>& channels) {
  std::unordered_set<std::string> names;
  for (const Channel& c : channels) {
    if (!names.insert(c.name).second) refuse(p, "declares two channels `" + c.name + "`");
  }
}

/// A policy must see something.
void check_observation(const PluginInstance& p) {
  const bool sees = std::any_of(p.channels.begin(), p.channels.end(),
                                [](const Channel& c) { return !c.privileged; });
  if (!sees) refuse(p, "declares no observation for a policy");
}

}  // namespace

void check_declarations(const Topology& topology, const Layout& layout, const PluginInstance& p) {
  const auto bodies = static_cast<int>(topology.bodies.size());
  const auto robots = static_cast<int>(topology.scenario.robots.size());
  const auto params = static_cast<int>(layout.param_info.size());
  if (p.kind == SKYBODY_CONTROLLER) check_controller(p);
  if (p.buffer_words < 0)
    refuse(p, "asks for a buffer of " + std::to_string(p.buffer_words) + " words");
  for (const WrenchSite& site : p.sites) {
    if (site.body < 0 || site.body >= bodies) {
      refuse(p, "names body " + std::to_string(site.body) + " of " + std::to_string(bodies));
    }
  }
  for (const Goal& goal : p.goals) {
    if (goal.robot < 0 || goal.robot >= robots || goal.body < 0 || goal.body >= bodies) {
      refuse(p, "declares a goal about robot " + std::to_string(goal.robot) + ", body " +
                    std::to_string(goal.body) + ", which there is not");
    }
  }
  for (const int param : p.writes) {
    if (param < 0 || param >= params) {
      refuse(p, "writes parameter " + std::to_string(param) + " of " + std::to_string(params));
    }
  }
  for (const Channel& c : p.channels) check_channel(p, c, robots);
  for (const Channel& c : p.infos) check_channel(p, c, robots);
  check_names(p, p.channels);
  check_names(p, p.infos);
  if (p.kind == SKYBODY_SENSOR && p.channels.empty()) refuse(p, "declares no output");
  if (p.kind == SKYBODY_TASK) check_observation(p);
}

}  // namespace skybody
