// The arguments of a batch of environments, shared by the commands that step one.
#pragma once

#include "core/batch/vec_env.h"

namespace CLI {
class App;
}

namespace skybody {

/// Declares --envs, --threads, --batch and --order (`fixed` or `arrival`), with the defaults that
/// `options` has.
void add_vec_env_options(CLI::App& command, VecEnvOptions& options);

}  // namespace skybody
