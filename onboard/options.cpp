#include "onboard/options.h"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <sstream>

#include "core/base/system/error.h"

namespace skybody::onboard {
namespace {

/// The numbers of a text with commas.
std::vector<double> numbers_of(const std::string& option, const std::string& text) {
  std::vector<double> values;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0' || !std::isfinite(value)) {
      throw Error(option + ": `" + word + "` is no number");
    }
    values.push_back(value);
  }
  if (values.empty()) throw Error(option + ": takes a number");
  return values;
}

double number_of(const std::string& option, const std::string& text, double low, double high) {
  const std::vector<double> values = numbers_of(option, text);
  if (values.size() == 1 && values[0] >= low && values[0] <= high) return values[0];
  std::ostringstream range;
  range << low << " ... " << high;
  throw Error(option + ": `" + text + "`; allowed: " + range.str());
}

/// NAME=NUMBER,...
std::pair<std::string, std::vector<double>> assignment(const std::string& option,
                                                       const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw Error(option + ": `" + text + "`; allowed: NAME=VALUE, several values with commas");
  }
  return {text.substr(0, equals), numbers_of(option, text.substr(equals + 1))};
}

using Take = std::function<void(const std::string& name, const std::string& value)>;

std::map<std::string, Take> options_with_value(Options& o) {
  return {
      {"--listen", [&o](auto&, auto& value) { o.listen = value; }},
      {"--peer", [&o](auto&, auto& value) { o.peer = value; }},
      {"--json", [&o](auto&, auto& value) { o.json = value; }},
      {"--gates", [&o](auto&, auto& value) { o.gates = value; }},
      {"--reference", [&o](auto&, auto& value) { o.reference = value; }},
      {"--seconds", [&o](auto& name, auto& value) { o.seconds = number_of(name, value, 0, 1e12); }},
      {"--fifo",
       [&o](auto& name, auto& value) { o.fifo = static_cast<int>(number_of(name, value, 1, 99)); }},
      {"--set", [&o](auto& name, auto& value) { o.params.push_back(assignment(name, value)); }},
      {"--limit", [&o](auto& name, auto& value) { o.limits.push_back(assignment(name, value)); }},
  };
}

std::map<std::string, bool*> switches(Options& o) {
  return {{"--about", &o.about},       {"--help", &o.help},  {"--mavlink", &o.mavlink},
          {"--lockstep", &o.lockstep}, {"--wait", &o.waits}, {"--lock-memory", &o.locks_memory}};
}

}  // namespace

Options parse_options(const std::vector<std::string>& arguments) {
  Options options;
  const auto with_value = options_with_value(options);
  const auto on = switches(options);
  for (std::size_t k = 0; k < arguments.size(); ++k) {
    const std::string& word = arguments[k];
    if (const auto found = on.find(word); found != on.end()) {
      *found->second = true;
    } else if (const auto takes = with_value.find(word); takes != with_value.end()) {
      if (k + 1 == arguments.size()) throw Error(word + " takes a value; see --help");
      takes->second(word, arguments[++k]);
    } else if (word.starts_with("-")) {
      throw Error("there is no option " + word + "; see --help");
    } else if (options.mission.empty()) {
      options.mission = word;
    } else {
      throw Error("`" + word + "`: one mission alone; see --help");
    }
  }
  if (options.mission.empty() && !options.help) {
    throw Error("give a mission: `skybody export POLICY --to onboard` writes one");
  }
  return options;
}

const char* help_text() {
  return "skybody onboard MISSION [OPTIONS]: flies a policy on a vehicle (docs/onboard.md)\n"
         "\n"
         "  --about             prints the mission and ends\n"
         "  --listen HOST:PORT  takes packets at this address; default: 127.0.0.1:14650\n"
         "  --peer HOST:PORT    answers there, and takes no packets of others\n"
         "  --mavlink           speaks MAVLink; default: our own packets\n"
         "  --lockstep          a step for each pose; default: by the clock\n"
         "  --wait              the policy waits for a packet that engages it\n"
         "  --seconds S         ends then; default: at Ctrl-C\n"
         "  --gates FILE        replaces the gates: x y z yaw [width height], a line each\n"
         "  --reference FILE    replaces the file of the path: CSV with t, x, y, z\n"
         "  --set PATH=V,...    a value of the task, such as task.target=0,0,2,0\n"
         "  --limit NAME=V,...  stale, lateness, tilt, fence (x, y, z, x, y, z), safe (0 stop,\n"
         "                      1 descend), safe_thrust, safe_time\n"
         "  --fifo N            SCHED_FIFO with priority N\n"
         "  --lock-memory       keeps all memory in RAM\n"
         "  --json FILE         writes the latencies\n";
}

}  // namespace skybody::onboard
