// The arguments of a batch of environments, shared by the commands that step one.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "core/batch/vec_env.h"

namespace skybody {

/// Declares --envs, --threads, --batch and --order (`fixed` or `arrival`), with the defaults that
/// `options` and `order` have.
void add_vec_env_options(CLI::App& command, VecEnvOptions& options, std::string& order);

}  // namespace skybody
