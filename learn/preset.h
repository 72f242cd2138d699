// Presets: the hyper-parameters and the number of steps that come with a scenario
// (docs/training.md, Presets).
#pragma once

#include <cstdint>
#include <string>

#include "learn/hyperparameters.h"

namespace skybody::learn {

/// Settings of a learner for a scenario.
struct Preset {
  Hyperparameters hyper;
  std::int64_t total_steps = 1'000'000;  ///< environment steps of a whole training
};

/// The preset of a scenario: that of its own file `training/NAME.yaml`, else of the nearest
/// scenario that it includes. Without one: the learner's defaults; `gradient` then has a horizon of
/// 0.64 s, if `action_seconds` is given.
/// @param scenario        a YAML file, or the name of a shipped one
/// @param action_seconds  between two actions [s]; 0: not known
/// @throws InputError, with places, if the file names an unknown learner or hyper-parameter, or a
///         value that is not allowed
Preset read_preset(const std::string& scenario, Algorithm algorithm, double action_seconds = 0.0);

}  // namespace skybody::learn
