#include "learn/preset.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/io/files/file.h"
#include "core/io/files/text.h"
#include "core/io/yaml/diagnostics.h"
#include "core/io/yaml/include_chain.h"
#include "learn/hyperparameter_text.h"
#include "learn/preset_file.h"

namespace skybody::learn {
namespace {

constexpr const char* kStepsKey = "total_steps";  // the only key that is no hyper-parameter
constexpr const char* kPythonLearner = "ppo";     // its section is read by Python
constexpr double kHorizon = 0.64;                 // [s]: in a shorter one the vehicle hardly moves
constexpr double kMostSteps = 640;                // of a horizon, which is kept in memory

[[noreturn]] void refuse(const SourceLocation& mark, const std::string& message) {
  throw InputError({{Severity::kError, mark, message}});
}

void check_learners(const std::vector<PresetSection>& sections) {
  std::vector<std::string> learners(std::begin(kAlgorithmNames), std::end(kAlgorithmNames));
  learners.emplace_back(kPythonLearner);
  for (const PresetSection& section : sections) {
    if (std::find(learners.begin(), learners.end(), section.learner) != learners.end()) continue;
    refuse(section.mark,
           "no learner `" + section.learner + "`" + suggestion(section.learner, learners));
  }
}

std::vector<PresetValue> values_of(const std::string& file, Algorithm algorithm) {
  if (!is_file(file)) return {};
  std::vector<PresetSection> sections = read_preset_file(file);
  check_learners(sections);
  for (PresetSection& section : sections) {
    if (section.learner == name(algorithm)) return std::move(section.values);
  }
  return {};
}

std::int64_t whole_steps(const PresetValue& value) {
  constexpr double kMost = 9e15;  // doubles below are exact
  const std::optional<double> steps = parse_number(value.text);
  if (steps && std::floor(*steps) == *steps && std::abs(*steps) < kMost) {
    return static_cast<std::int64_t>(*steps);
  }
  refuse(value.mark, value.key + ": `" + value.text + "` is not a whole number");
}

void apply(const PresetValue& value, Algorithm algorithm, Hyperparameters& hyper) {
  std::vector<std::string> names = hyperparameter_names(algorithm);
  if (std::find(names.begin(), names.end(), value.key) == names.end()) {
    names.emplace_back(kStepsKey);
    refuse(value.mark, "no hyper-parameter `" + value.key + "`" + suggestion(value.key, names));
  }
  try {
    set(hyper, algorithm, value.key + "=" + value.text);
  } catch (const Error& error) {
    refuse(value.mark, error.what());
  }
}

/// Whether the values are allowed; those of one key are left out, or only they are applied.
bool is_allowed(const std::vector<PresetValue>& values, Algorithm algorithm, const PresetValue& one,
                bool alone) {
  Hyperparameters hyper;
  for (const PresetValue& value : values) {
    const bool is_one = &value == &one;
    if (value.key != kStepsKey && is_one == alone) apply(value, algorithm, hyper);
  }
  try {
    check(hyper, algorithm);
  } catch (const Error&) {
    return false;
  }
  return true;
}

/// The place of the value that is not allowed: alone, or else together with the others.
SourceLocation place_of_mistake(const std::vector<PresetValue>& values, Algorithm algorithm,
                                const std::string& file) {
  for (const PresetValue& value : values) {
    if (!is_allowed(values, algorithm, value, true)) return value.mark;
  }
  for (const PresetValue& value : values) {
    if (is_allowed(values, algorithm, value, false)) return value.mark;
  }
  return {file, 0, 0};
}

Hyperparameters fitted(double action_seconds) {
  Hyperparameters hyper;
  const double steps = std::nearbyint(kHorizon / action_seconds);
  hyper.envs = 32;
  hyper.rollout_steps = static_cast<int>(std::clamp(steps, 1.0, kMostSteps));
  hyper.learning_rate = 6e-3;
  hyper.max_grad_norm = 1.0;
  return hyper;
}

}  // namespace

Preset read_preset(const std::string& scenario, Algorithm algorithm, double action_seconds) {
  const std::string file = training_presets(scenario_file(scenario));
  const std::vector<PresetValue> values = values_of(file, algorithm);
  Preset preset;
  if (values.empty() && algorithm == Algorithm::kGradient && action_seconds > 0.0) {
    preset.hyper = fitted(action_seconds);
  }
  for (const PresetValue& value : values) {
    if (value.key == kStepsKey) {
      preset.total_steps = whole_steps(value);
    } else {
      apply(value, algorithm, preset.hyper);
    }
  }
  try {
    check(preset.hyper, algorithm);
  } catch (const Error& error) {
    refuse(place_of_mistake(values, algorithm, file),
           std::string(name(algorithm)) + ": " + error.what());
  }
  return preset;
}

}  // namespace skybody::learn
