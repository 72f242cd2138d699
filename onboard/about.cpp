#include "onboard/about.h"

#include <cstdarg>
#include <cstdio>

#include "core/plugin_abi/signals.h"
#include "onboard/safe_command.h"

namespace skybody::onboard {
namespace {

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char line[512];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(line, sizeof line, pattern, arguments);
  va_end(arguments);
  return line;
}

std::string source_of(const Mission& mission, const Needs& needs, std::size_t column) {
  for (const std::string& name : needs.unknown) {
    if (name == mission.columns[column].name) return "  UNKNOWN on a vehicle";
  }
  std::string text;
  for (const int body : needs.bodies_of[column]) {
    const SkybodyBodyInfo& b = mission.setup.bodies()[static_cast<std::size_t>(body)];
    const SkybodyRobotInfo& r = mission.setup.robots()[static_cast<std::size_t>(b.robot)];
    text += format("  needs body %d (%s.%s)", body, r.name, b.name);
  }
  return text;
}

}  // namespace

const char* signal_word(int signal) {
  static constexpr const char* kWords[] = {
#define SKYBODY_ROW(symbol, type, word, least, most, doc) #word,
      SKYBODY_SIGNALS(SKYBODY_ROW)
#undef SKYBODY_ROW
  };
  return kWords[signal];
}

std::string about(const Mission& m, const Needs& needs) {
  std::string text = format("mission  %s (hash %s), task %s %s, robot %s, a step each %g s\n",
                            m.scenario.c_str(), m.scenario_hash.c_str(), m.task.c_str(),
                            m.task_version.c_str(), m.vehicle().name, m.period());
  for (std::size_t k = 0; k < m.columns.size(); ++k) {
    const Column& c = m.columns[k];
    text += format("column   %-18s %3d %-6s %s%s\n", c.name.c_str(), c.count, c.unit.c_str(),
                   c.doc.c_str(), source_of(m, needs, k).c_str());
  }
  if (needs.imu) text += "needs    an IMU\n";
  for (const ActionRange& range : m.actions) {
    for (std::size_t k = 0; k < range.low.size(); ++k) {
      text += format("action   %s[%zu]: %g ... %g\n", range.name.c_str(), k, range.low[k],
                     range.high[k]);
    }
  }
  const Limits& l = m.limits;
  text += format("command  %s, %d values\n", signal_word(m.chain().signal), m.chain().count);
  text += format("limits   stale %g s, lateness %g s, tilt %g rad, fence %g %g %g ... %g %g %g m\n",
                 l.stale, l.lateness, l.tilt, l.fence_low[0], l.fence_low[1], l.fence_low[2],
                 l.fence_high[0], l.fence_high[1], l.fence_high[2]);
  text += l.safe == SafeAction::kDescend && can_descend(m.chain().signal)
              ? format("safe     descend at %g of the hover thrust (%.3g N) for %g s\n",
                       l.safe_thrust, m.mass() * m.gravity(), l.safe_time)
              : std::string("safe     stop\n");
  return text;
}

}  // namespace skybody::onboard
