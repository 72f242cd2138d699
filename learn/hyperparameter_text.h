// Parses hyper-parameters given on a command line.
#pragma once

#include <string>

#include "learn/hyperparameters.h"

namespace skybody::learn {

/// The activation of hidden layers called `word`: tanh, relu or elu.
/// @throws Error for any other word, with the allowed ones
Activation hidden_activation(const std::string& word);

/// Sets one hyper-parameter.
/// @param setting  "NAME=VALUE" as for `skybody train --set`: numbers (integers as 2e6, too), true
///        or false, sizes as 64,64, or an activation
/// @throws Error if there is no "=", if the algorithm has no such name (the message contains the
///         nearest one), or if the text cannot be parsed; `hyper` is then unchanged. check() checks
///         ranges
void set(Hyperparameters& hyper, Algorithm algorithm, const std::string& setting);

}  // namespace skybody::learn
