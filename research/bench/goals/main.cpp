// The C++ lines of the table of goals, as JSON: every rate of ours and that of the limit, from one
// run. research/speed/goals.py prints the table and adds the measurements from Python.
//
//   bench_goals [--full | --trial] [--out FILE]
//
// --full: longer trials, for results to keep. --trial: one short trial per figure, for tests.
#include <skybody/build_info.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>

#include "app/report/machine.h"
#include "core/version.h"
#include "research/bench/goals/contest.h"
#include "research/bench/goals/figure.h"
#include "research/bench/goals/footprint.h"
#include "research/bench/limit/check.h"
#include "research/bench/limit/loops.h"
#include "research/bench/limit/pin_rod_task.h"

namespace skybody::bench {
namespace {

constexpr const char* kActions[] = {"hold", "zero", "random"};

/// Removes the scalar loops: the goals are ratios to the lanes limit.
std::vector<limit::LoopKind> in_lanes(const std::vector<limit::LoopKind>& loops) {
  std::vector<limit::LoopKind> out;
  for (const limit::LoopKind& loop : loops) {
    if (loop.width > 1) out.push_back(loop);
  }
  return out.empty() ? loops : out;
}

/// Measures and collects.
class Goals {
 public:
  explicit Goals(const Effort& effort) : effort_(effort), loops_(limit::all_loops()) {
    loops_ = {in_lanes(loops_.hover), in_lanes(loops_.payload), in_lanes(loops_.pin_rod),
              in_lanes(loops_.team_of_2), in_lanes(loops_.team_of_20)};
  }

  void all() {
    hover();
    resting();
    tree("payload", {"payload", {}, {}}, loops_.payload);
    plain_payload();
    tree("rod on a pin", {SKYBODY_BENCH_SCENARIOS "/pin_rod.yaml", {}, {}}, loops_.pin_rod,
         hover_with_rod());
    team("formation of 2", "formation_2", loops_.team_of_2);
    team("formation of 20", "formation_20", loops_.team_of_20);
    scaling();
    footprint();
  }
  const std::vector<Figure>& figures() const { return figures_; }

 private:
  /// The goal applies to `hold` and `off`; for the other streams it is halved.
  void contest(const std::string& what, const Contest& contest, double goal) {
    std::fprintf(stderr, "  %s, %s, %d threads\n", what.c_str(), contest.actions.c_str(),
                 contest.threads);
    const Outcome o = run_contest(contest, effort_);
    const double share = contest.actions == "hold" || contest.actions == "off" ? 1.0 : 0.5;
    figures_.push_back({what, contest.actions, contest.threads, "M steps/s", 1e-6 * o.ours,
                        1e-6 * o.limit, "limit, " + o.loop, o.ours / o.limit, ">=", share * goal,
                        o.near_share});
  }

  /// Vehicles that do not fly rest on the ground before the measurement, and no horizon, which
  /// would end all episodes in one trial, puts them into the air again.
  static void let_rest(Contest& contest) {
    if (contest.actions == "hold") return;
    contest.settle = 2.0;
    contest.scenario.overrides.emplace_back("stepping.horizon=0");
  }

  Contest hover_contest(int repeats) const {
    Contest c;
    c.scenario = {"hover", {}, {}};
    c.loops = loops_.hover;
    c.repeats = repeats;
    return c;
  }

  void hover() {
    for (const int repeats : {1, 10}) {
      for (const int threads : {1, 2}) {
        for (const char* actions : kActions) {
          Contest c = hover_contest(repeats);
          c.threads = threads;
          c.actions = actions;
          let_rest(c);
          contest("hover, K=" + std::to_string(repeats), c, repeats == 1 ? 0.7 : 0.6);
        }
      }
    }
  }

  /// Vehicles on the ground with rotors at rest; the limit has no ground, so its vehicles hover.
  void resting() {
    for (const int threads : {1, 2}) {
      Contest c = hover_contest(1);
      c.scenario.overrides = {"stepping.horizon=0", "robots.quad.rotor_speed=0",
                              "randomization[0].parameters.position_min=[-5, -5, 0.06]",
                              "randomization[0].parameters.position_max=[5, 5, 0.061]"};
      c.actions = "off";
      c.constant = -1.0f;
      c.limit_actions = "hold";
      c.settle = 1.0;
      c.threads = threads;
      contest("all resting on the ground", c, 0.3);
    }
  }

  /// Action that carries base and rod: the hold policy ignores a load whose link begins at the
  /// base.
  static float hover_with_rod() {
    const double weight = (limit::kMass + limit::kPinRod.mass) * limit::kGravity;
    const double speed = std::sqrt(weight / (4.0 * limit::kThrust));
    return static_cast<float>(speed / limit::PinRodTask<double>::kSpeedScale - 1.0);
  }

  /// @param hold  action in place of the hold policy's
  void tree(const std::string& name, const LoadOptions& scenario,
            const std::vector<limit::LoopKind>& loops, std::optional<float> hold = {}) {
    for (const int threads : {1, 2}) {
      for (const char* actions : kActions) {
        Contest c;
        c.scenario = scenario;
        c.loops = loops;
        c.actions = actions;
        if (c.actions == "hold") c.constant = hold;
        let_rest(c);
        c.threads = threads;
        contest(name + ", K=1", c, 0.5);
        if (actions != kActions[0]) continue;
        c.scenario.overrides.push_back("stepping.dynamics=simbody");
        const double simbody = engine_rate(c, {effort_.trials / 4 + 1, 4.0 * effort_.seconds});
        const double ours = figures_.back().ours;
        figures_.push_back({name + " against Simbody", actions, threads, "M steps/s", ours,
                            1e-6 * simbody, "dynamics: simbody", 1e6 * ours / simbody, ">=", 30.0});
      }
    }
  }

  /// For information: the payload without its IMU and drawn constants, which the limit does not
  /// have.
  void plain_payload() {
    Contest c;
    c.scenario = {"payload",
                  {"sensors=[]",
                   "randomization=[{plugin: start, parameters: {robot: quad, position_min: [-5, "
                   "-5, 1.5], position_max: [5, 5, 3]}}]"},
                  {}};
    c.loops = loops_.payload;
    contest("payload, K=1, no IMU, nominal", c, 0.5);
    figures_.back().sense.clear();
  }

  /// With the joint observation, as shipped.
  void team(const std::string& name, const char* scenario,
            const std::vector<limit::LoopKind>& loops) {
    for (const int threads : {1, 2}) {
      Contest c;
      c.scenario = {scenario, {"stepping.horizon=1000"}, {}};
      c.loops = loops;
      c.envs = 32;
      c.threads = threads;
      contest(name + ", 32 environments", c, 0.5);
    }
  }

  /// Ratio to the limit by number of environments, and the gain of a second thread.
  void scaling() {
    double at_1024 = 0.0;
    for (const int envs : {1024, 64, 256, 4096, 16384}) {
      Contest c = hover_contest(1);
      c.envs = envs;
      c.threads = 2;
      Outcome two = run_contest(c, effort_);
      c.threads = 1;
      const Outcome one = run_contest(c, effort_);
      const double ratio = one.ours / one.limit;
      if (envs == 1024) at_1024 = ratio;
      const std::string what = "hover, " + std::to_string(envs) + " environments";
      figures_.push_back({what + ": ratio by that at 1024", "hold", 1, "M steps/s", 1e-6 * one.ours,
                          1e-6 * one.limit, "limit, " + one.loop, ratio / at_1024, ">=", 0.8});
      if (envs < 1024) continue;
      const double gain = two.ours / one.ours, limit_gain = two.limit / one.limit;
      figures_.push_back({what + ": gain of two threads", "hold", 2, "times", gain, limit_gain,
                          "the limit's gain", gain / limit_gain, ">=", 0.95});
    }
  }

  void footprint() {
    const double bytes = bytes_per_environment({"hover", {}, {}}, 16384);
    figures_.push_back({"memory of a hover environment", "", 0, "bytes", bytes, 2048.0, "2 KiB",
                        bytes / 2048.0, "<=", 1.0});
    const std::string drawn =
        "{plugin: vehicle_constants, name: inertia, parameters: {robot: quad, mass: [0.9, 1.1], "
        "inertia: [0.9, 1.1], "
        "thrust_constant: [0.9, 1.1], moment_constant: [0.9, 1.1], drag: [0.9, 1.1], "
        "rolling_moment: [0.9, 1.1], rotor_inertia: [0.9, 1.1], tau_up: [0.9, 1.1], tau_down: "
        "[0.9, 1.1]}}";
    const std::string start =
        "{plugin: start, parameters: {robot: quad, position_min: [-5, -5, 0.3], position_max: [5, "
        "5, 3], yaw_min: -0.72, yaw_max: 0.72}}";
    const std::string randomization = "randomization=[" + drawn + ", " + start + "]";
    const double tree = reset_time({"hover", {randomization}, {}});
    figures_.push_back({"reset with drawn constants, tree", "", 0, "us", 1e6 * tree, 1.0, "1 us",
                        1e6 * tree, "<=", 1.0});
    const double simbody = reset_time({"hover", {randomization, "stepping.dynamics=simbody"}, {}});
    const double rebuild = bare_rebuild_time();
    figures_.push_back({"reset with drawn constants, simbody", "", 0, "us", 1e6 * simbody,
                        1e6 * rebuild, "bare rebuild", simbody / rebuild, "<=", 1.2});
  }

  Effort effort_;
  limit::Loops loops_;
  std::vector<Figure> figures_;
};

int run(const Effort& effort, bool full, const char* out) {
  if (!limit::check(limit::all_loops())) return 1;
  Goals goals(effort);
  goals.all();
  std::vector<std::string> lines;
  for (const Figure& f : goals.figures()) lines.push_back(f.json());
  JsonObject json;
  json.set_text("machine", machine_name())
      .set_text("processor", processor_name())
      .set("processors", std::to_string(processor_count()))
      .set_text("skybody_version", version())
      .set_text("simbody", SKYBODY_SIMBODY_VERSION)
      .set("simbody_asserts", SKYBODY_SIMBODY_NDEBUG != 0 ? "false" : "true")
      .set("full", full ? "true" : "false")
      .set("figures", json_array(lines));
  if (out == nullptr) {
    std::printf("%s\n", json_indented(json.text()).c_str());
  } else {
    std::ofstream(out) << json_indented(json.text()) << "\n";
  }
  return 0;
}

}  // namespace
}  // namespace skybody::bench

int main(int argc, char** argv) {
  using skybody::bench::Effort;
  bool full = false;
  Effort effort;
  const char* out = nullptr;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--full") == 0) full = true;
    if (std::strcmp(argv[i], "--trial") == 0) effort = {1, 0.0005};
    if (std::strcmp(argv[i], "--out") == 0 && i + 1 < argc) out = argv[++i];
  }
  return skybody::bench::run(full ? Effort{200, 0.01} : effort, full, out);
}
