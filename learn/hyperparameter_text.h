// Hyper-parameters as they are written on a command line.
#pragma once

#include <string>

#include "learn/hyperparameters.h"

namespace skybody::learn {

/// The activation of hidden layers that a word names: tanh, relu or elu.
/// @throws Error for another word, with the allowed ones
Activation hidden_activation(const std::string& word);

/// Gives one hyper-parameter its value.
/// @param setting  "NAME=VALUE" as for `skybody train --set`: numbers (whole ones as 2e6, too),
/// true
///                 or false, sizes as 64,64, or an activation
/// @throws Error, and nothing has changed, where there is no "=", where the algorithm has no such
///         name (with the nearest one), or where the text is no value of it. Ranges are for check()
void set(Hyperparameters& hyper, Algorithm algorithm, const std::string& setting);

}  // namespace skybody::learn
