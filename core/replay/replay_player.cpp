#include "core/replay/replay_player.h"

#include <algorithm>
#include <cstring>
#include <sstream>

#include "core/base/math/hash.h"
#include "core/base/system/error.h"
#include "core/base/system/printable.h"
#include "core/batch/environment_states.h"
#include "core/io/files/file.h"
#include "core/replay/replay_recorder.h"

namespace skybody {
namespace {

PoolOptions options_of(const ReplayHeader& header, int threads) {
  PoolOptions options;
  options.envs = header.envs;
  options.threads = threads;
  options.autoreset = autoreset_from(header.autoreset).value();  // checked by the reader
  options.seed = header.seed;
  options.first_env_id = header.first_env_id;
  options.keep_hash = true;
  return options;
}

/// Compares received rows with the recording's.
class Comparer : public PoolObserver {
 public:
  Comparer(const ReplayReader& replay, ReplayReport& report)
      : replay_(replay),
        report_(report),
        same_step_(replay.header().autoreset == "same_step"),
        count_(static_cast<std::size_t>(replay.header().envs)),
        parted_(count_.size()) {}

  void received(const Batch& rows, const EnvironmentStates& environments) override {
    for (int k = 0; k < rows.rows; ++k) {
      const int env = rows.env_id[static_cast<std::size_t>(k)];
      const std::size_t number = count_[static_cast<std::size_t>(env)]++;
      if (number >= replay_.transitions(env)) continue;  // was in flight when the recording ended
      ++report_.transitions;
      if (parted_[static_cast<std::size_t>(env)] != 0) continue;
      compare(rows, k, environments, env, number);
    }
  }

 private:
  void compare(const Batch& rows, int k, const EnvironmentStates& environments, int env,
               std::size_t number) {
    ReplayParting parting;
    parting.place = replay_.place(env, number);
    parting.transition = number + 1;
    parting.first = replay_.row(parting.place);
    const bool states = !replay_.header().state_names.empty();
    read_row(rows, k, environments, same_step_, states, parting.second);
    parting.differences = compare_rows(replay_.header(), parting.first, parting.second);
    const bool same_hash = parting.first.hash == parting.second.hash;
    if (same_hash && parting.differences.empty()) return;
    parted_[static_cast<std::size_t>(env)] = 1;
    if (same_hash) report_.remark = kRowsChanged;
    report_.add(std::move(parting));
  }

  const ReplayReader& replay_;
  ReplayReport& report_;
  bool same_step_;
  std::vector<std::size_t> count_;  ///< transitions received, per environment
  std::vector<std::uint8_t> parted_;
};

/// Repeats the recorded events. Environments are received only if the next event requires it.
class Player {
 public:
  Player(ReplayReader& replay, Pool& envs) : replay_(replay), envs_(envs), in_flight_(size()) {}

  void play() {
    while (replay_.next(event_)) apply();
    receive_all();
  }

 private:
  std::size_t size() const { return static_cast<std::size_t>(envs_.envs()); }

  void apply() {
    switch (event_.kind) {
      case ReplayEventKind::kSend:
        await(event_.env_ids);
        envs_.send(event_.actions, event_.env_ids);
        return mark_sent();
      case ReplayEventKind::kReset:
        return reset();
      case ReplayEventKind::kReseed:
        receive_all();
        envs_.send_reset(event_.argument);
        std::fill(in_flight_.begin(), in_flight_.end(), std::uint8_t{1});
        return;
      case ReplayEventKind::kRestore:
        receive_all();
        return envs_.restore(event_.saved);
      case ReplayEventKind::kFork:
        receive_all();
        return envs_.fork(event_.env_ids[0], std::span(event_.env_ids).subspan(1),
                          event_.argument != 0);
      case ReplayEventKind::kSetParam:
        return set_param();
      case ReplayEventKind::kRequest:
        return request();
    }
  }

  void reset() {
    await(event_.env_ids);
    std::vector<std::uint8_t> mask(size());
    for (const std::int32_t env : event_.env_ids) mask[static_cast<std::size_t>(env)] = 1;
    envs_.send_reset(mask);
    mark_sent();
  }

  void set_param() {
    receive_all();
    double value;
    std::memcpy(&value, &event_.argument, sizeof value);
    envs_.set_param(event_.env_ids[0], event_.path, value);
  }

  /// No receive is needed first: transitions in flight are not affected by a request.
  void request() {
    const RequestTime when =
        (event_.argument & 1) != 0 ? RequestTime::kNextReset : RequestTime::kNextStep;
    if ((event_.argument & 2) != 0) return envs_.randomize(when, event_.env_ids);
    std::vector<ParamChange> changes;
    std::istringstream lines(event_.path);
    for (std::string line; std::getline(lines, line);) changes.push_back(read_param_change(line));
    envs_.request(changes, when, event_.env_ids);
  }

  void mark_sent() {
    for (const std::int32_t env : event_.env_ids) in_flight_[static_cast<std::size_t>(env)] = 1;
  }

  void await(const std::vector<std::int32_t>& ids) {
    const auto flies = [&](std::int32_t env) {
      return in_flight_[static_cast<std::size_t>(env)] != 0;
    };
    if (std::any_of(ids.begin(), ids.end(), flies)) receive_all();
  }

  void receive_all() {
    while (envs_.in_flight() > 0) envs_.recv();
    std::fill(in_flight_.begin(), in_flight_.end(), std::uint8_t{0});
  }

  ReplayReader& replay_;
  Pool& envs_;
  ReplayEvent event_;
  std::vector<std::uint8_t> in_flight_;
};

/// Line of the first difference between two texts, from 1; 0 if there is none.
int first_different_line(const std::string& a, const std::string& b) {
  std::istringstream first(a), second(b);
  std::string x, y;
  for (int line = 1;; ++line) {
    const bool more_x = static_cast<bool>(std::getline(first, x));
    const bool more_y = static_cast<bool>(std::getline(second, y));
    if (!more_x && !more_y) return 0;
    if (more_x != more_y || x != y) return line;
  }
}

std::string what_changed(const ReplayHeader& header, const Scenario& scenario) {
  const int line = first_different_line(header.scenario_text, scenario.text);
  if (line == 0) return "a model, a rotors file or a default of a plugin has changed since";
  return "its merged text differs from line " + std::to_string(line) + " on";
}

}  // namespace

LoadOptions replay_load_options(const ReplayHeader& header) {
  LoadOptions options;
  options.scenario = is_file(header.scenario_file) ? header.scenario_file : header.scenario_name;
  options.overrides = header.overrides;
  return options;
}

void check_same_scenario(const ReplayReader& replay, const CompiledScenario& compiled) {
  const ReplayHeader& header = replay.header();
  const Scenario& scenario = compiled.scenario();
  if (header.scenario_hash == scenario.hash) return;
  throw Error(replay.file().string() + " was recorded in the scenario `" +
              printable(header.scenario_name) + "` with hash " + to_hex(header.scenario_hash) +
              "; " + scenario.file + " has hash " + to_hex(scenario.hash) +
              " now: " + what_changed(header, scenario));
}

ReplayReport play(ReplayReader& replay, const std::shared_ptr<const CompiledScenario>& compiled,
                  int threads) {
  check_same_scenario(replay, *compiled);
  ReplayReport report;
  Pool envs(compiled, options_of(replay.header(), threads));
  envs.observe(std::make_shared<Comparer>(replay, report));
  try {
    Player(replay, envs).play();
  } catch (const Error& error) {
    // After a difference, recorded calls may no longer be possible.
    if (!report.where) throw;
    report.remark = std::string("the replay stopped early: ") + error.what();
  }
  if (report.identical() && report.transitions < replay.transitions()) {
    report.remark = "the replay has " + std::to_string(report.transitions) + " of the " +
                    std::to_string(replay.transitions()) + " recorded transitions";
  }
  return report;
}

}  // namespace skybody
