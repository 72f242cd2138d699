// Actions, commands and changes in flight, for a single environment and for one environment in a
// batch. The first line of an input names a scenario. The other lines are calls (flight_script.h)
// or batch commands:
// - `batch VALUES`: environment 1 gets these values, the others always the same ones
// - `set PARAMETER VALUE`
// - `adopt SOURCE REKEY`
// - `end`: a reset of environment 1
#include <cstdlib>
#include <map>
#include <sstream>

#include "tests/fuzz/areas.h"
#include "tests/fuzz/batch_rows.h"
#include "tests/fuzz/flight_check.h"
#include "tests/fuzz/flight_script.h"
#include "tests/fuzz/plugin_source.h"

namespace skybody::fuzz {
namespace {

constexpr int kEnvs = 4, kChanged = 1;
constexpr int kMostLines = 40;          // per script
constexpr std::size_t kMostBatch = 12;  // `batch` lines per script
const char* const kScenarios[] = {"hover", "payload",      "collision",          "formation_2",
                                  "boom",  "hard_landing", "cooperative_payload"};

const char* const kScripts[] = {
    "\nstep 0.1 0.2 -0.3 0.4\nlook\nstep 1 1 1 1\nbatch 0.5 0.5 0.5 0.5\nbatch -1 1 0 0\n",
    "\ncommand 0 100 100 100 100\nadvance 5\nevaluate\ncommand 0 0 0 0 0\nadvance 2\nlook\n",
    "\nteleport 0 0 0 2 1 0 0 0 1 2 3 0.1 0.2 0.3\nadvance 3\nlook\nevaluate\nreset\n",
    "\nscale 0 1.1\nscale 7 0.999\nstep 0 0 0 0\nmass 0 0 1.5 0 0 0.01\nadvance 4\nevaluate\n",
    "\nrotor 0 1 0 2e-6\nrotor 0 2 2 1500\nstep 0.2 0.2 0.2 0.2\nfork 1\nstep 0 0 0 0\nseed 5\n",
    "\nsave\nstep 0.3 0.3 0.3 0.3\nrestore\nrandomize\nstep 0.1 0.1 0.1 0.1\nfork 0\nreset\n",
    "\nbatch 0.1 0.1 0.1 0.1\nset 0 1.2\nbatch 0.2 0.2 0.2 0.2\nadopt 2 1\nbatch 0 0 0 0\nend\n",
};

PoolOptions batch_options() {
  PoolOptions options;
  options.envs = kEnvs;
  options.threads = 1;
  return options;
}

/// Environments of one scenario; only environment 1 ever gets other inputs.
class Flock {
 public:
  explicit Flock(std::shared_ptr<const CompiledScenario> compiled)
      : envs_(std::move(compiled), batch_options()),
        actions_(static_cast<std::size_t>(kEnvs) * width(), 0.2f) {
    restart();
    const std::vector<float> same(width(), 0.2f);
    for (std::size_t k = 0; k < kMostBatch; ++k) expected_.push_back(step(same));
  }

  void restart() {
    steps_ = 0;
    envs_.send_reset(std::uint64_t{3});
    BatchRows::receive(envs_);
  }

  /// @returns false if there is no such call
  bool call(const std::string& name, const Values& values) {
    if (name == "batch") return batch(values);
    if (name == "set") return set(values);
    if (name == "adopt") return adopt(values);
    if (name == "end") return end();
    return false;
  }

 private:
  std::size_t width() const { return static_cast<std::size_t>(envs_.compiled().action_size()); }

  BatchRows step(const std::vector<float>& row) {
    std::copy(row.begin(), row.end(), actions_.begin() + static_cast<std::ptrdiff_t>(width()));
    envs_.send(actions_);
    return BatchRows::receive(envs_);
  }

  bool batch(const Values& values) {
    if (steps_ == kMostBatch) return true;
    std::vector<float> row(width(), 0.2f);
    for (std::size_t k = 0; k < std::min(row.size(), values.size()); ++k) {
      row[k] = static_cast<float>(values[k]);
    }
    check_others(step(row), expected_[steps_++], kEnvs, kChanged);
    return true;
  }

  bool set(const Values& values) {
    const auto& params = envs_.compiled().layout().param_info;
    if (values.size() < 2 || !(std::abs(values[0]) < 1e9) || params.empty()) return true;
    const std::size_t k = static_cast<std::size_t>(std::abs(values[0])) % params.size();
    envs_.set_param(kChanged, params[k].path, values[1]);
    return true;
  }

  bool adopt(const Values& values) {
    const int sources[] = {0, 2, 3};
    const std::size_t k =
        !values.empty() && values[0] > 0 && values[0] < 3 ? static_cast<std::size_t>(values[0]) : 0;
    envs_.fork(sources[k], std::vector<std::int32_t>{kChanged}, values.size() > 1);
    return true;
  }

  bool end() {
    const std::vector<std::uint8_t> mask = {0, 1, 0, 0};
    envs_.send_reset(mask);
    BatchRows::receive(envs_);
    return true;
  }

  Pool envs_;
  std::vector<float> actions_;
  std::vector<BatchRows> expected_;
  std::size_t steps_ = 0;
};

Values values_of(const std::string& text) {
  Values values;
  const char* at = text.c_str();
  for (char* end = nullptr;; at = end) {
    const double value = std::strtod(at, &end);
    if (end == at) return values;
    values.push_back(value);
  }
}

class ActionArea : public Area {
 public:
  ActionArea() {
    for (const char* name : kScenarios) {
      Diagnostics diagnostics;
      LoadOptions options;
      options.scenario = name;
      environments_[name] = compile_scenario(options, shipped_plugins(), diagnostics);
      diagnostics.throw_if_errors();
      for (const char* script : kScripts) material_.seeds.push_back(std::string(name) + script);
    }
    for (const char* name : kScenarios) material_.words.emplace_back(name);
    for (const std::string& name : FlightScript::names()) material_.words.push_back(name);
    for (const char* word : {"batch", "set", "adopt", "end", "nan", "inf", "-inf", "1e300", "1e38",
                             "1e-45", "5e-324", "-1e300", "1e6", "999999", "1e150"}) {
      material_.words.emplace_back(word);
    }
  }

  void begin(const std::filesystem::path&) override { flocks_.clear(); }

  Answer run(const std::string& input, bool) override {
    std::istringstream lines(input);
    std::string line;
    std::getline(lines, line);
    if (environments_.count(line) == 0) line = kScenarios[0];
    FlightScript script(environments_[line]);
    Flock& flock = flock_of(line);
    flock.restart();
    Answer answer = Answer::kAccepted;
    for (int k = 0; k < kMostLines && std::getline(lines, line); ++k) {
      if (!call(script, flock, line)) answer = Answer::kRefused;
    }
    return answer;
  }

  std::size_t smallest_leak() const override { return kSmallLeak; }

 private:
  Flock& flock_of(const std::string& name) {
    auto& flock = flocks_[name];
    if (flock == nullptr) flock = std::make_unique<Flock>(environments_[name]);
    return *flock;
  }

  /// @returns false if the call was refused
  static bool call(FlightScript& script, Flock& flock, const std::string& line) {
    const std::size_t space = std::min(line.find(' '), line.size());
    const std::string name = line.substr(0, space);
    const Values values = values_of(line.substr(space));
    try {
      if (!script.call(name, values) && !flock.call(name, values)) return false;
    } catch (const Error& error) {
      check_message(error.what());
      return false;
    }
    check_rows(script.simulation());
    return true;
  }

  std::map<std::string, std::shared_ptr<const CompiledScenario>> environments_;
  std::map<std::string, std::unique_ptr<Flock>> flocks_;
};

}  // namespace

std::unique_ptr<Area> make_action_area(const AreaOptions&) {
  return std::make_unique<ActionArea>();
}

}  // namespace skybody::fuzz
