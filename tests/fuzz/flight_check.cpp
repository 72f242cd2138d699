#include "tests/fuzz/flight_check.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/system/printable.h"
#include "core/io/files/text.h"
#include "tests/fuzz/plugin_source.h"

namespace skybody::fuzz {
namespace {

/// Physics steps per check: the check exercises the engine, not long actions.
constexpr std::int64_t kPhysicsSteps = 20;
constexpr int kTransitions = 3;
/// With more SUNDIALS steps per physics step than this, an input may legitimately take any time.
constexpr std::int64_t kMostSolverSteps = 2000;

struct Outcome {
  Answer answer = Answer::kRefused;
  std::string messages;
  std::uint64_t hash = 0;
  bool operator==(const Outcome&) const = default;
};

bool takes_too_long(const Stepping& stepping) {
  return is_error_controlled(stepping.integrator) && stepping.solver.max_steps > kMostSolverSteps;
}

std::uint64_t fly(std::shared_ptr<const CompiledScenario> compiled) {
  Simulation simulation(std::move(compiled), 1, 0);
  const Stepping& stepping = simulation.scenario().stepping;
  simulation.reset();
  check_rows(simulation);
  if (takes_too_long(stepping)) return simulation.hash();
  const std::vector<float> action(static_cast<std::size_t>(simulation.action_size()), 0.1f);
  for (int k = 0; k < kTransitions && !simulation.done(); ++k) {
    if (stepping.action_repeat <= kPhysicsSteps) {
      simulation.step(action);
    } else if (simulation.advance(kPhysicsSteps)) {
      simulation.evaluate();
    }
    check_rows(simulation);
  }
  return simulation.hash();
}

Outcome load_and_fly(const LoadOptions& options) {
  Outcome outcome;
  Diagnostics diagnostics;
  auto compiled = compile_scenario(options, shipped_plugins(), diagnostics);
  if (compiled == nullptr) {
    outcome.messages = check_refusal(diagnostics);
    return outcome;
  }
  outcome.answer = Answer::kAccepted;
  outcome.messages = diagnostics.to_string();
  outcome.hash = fly(std::move(compiled));
  return outcome;
}

}  // namespace

void check_message(const std::string& message) {
  if (message.empty()) wrong_answer("an empty message");
  if (printable(message) != message) {
    wrong_answer("a message that is no printable UTF-8 in one line: " + message);
  }
}

std::string check_refusal(const Diagnostics& diagnostics) {
  bool names_a_place = false;
  for (const Diagnostic& diagnostic : diagnostics.all()) {
    names_a_place |= diagnostic.severity == Severity::kError && !diagnostic.mark.file.empty();
    check_message(diagnostic.to_string());
  }
  if (!names_a_place) wrong_answer("refused without a place: " + diagnostics.to_string());
  return diagnostics.to_string();
}

void check_finite(const char* what, std::span<const float> values) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k])) continue;
    wrong_answer(std::string(what) + " " + std::to_string(k) + " is not finite");
  }
}

void check_rows(const Simulation& simulation, Faults faults) {
  if (faults == Faults::kAreAnything && simulation.fault()) return;
  const float reward = simulation.reward();
  check_finite("observation", simulation.observation());
  check_finite("reward", {&reward, 1});
  check_finite("agent reward", simulation.agent_rewards());
  if (!simulation.fault()) check_finite("info", simulation.info());
}

Answer check_flight(const LoadOptions& options, bool thorough) {
  const Outcome outcome = load_and_fly(options);
  if (thorough && load_and_fly(options) != outcome) {
    wrong_answer("the second time another answer: " + outcome.messages);
  }
  return outcome.answer;
}

}  // namespace skybody::fuzz
