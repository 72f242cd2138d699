// The options of a batch of environments, shared by the commands that step one.
#pragma once

#include "core/batch/pool.h"

namespace CLI {
class App;
}

namespace skybody {

/// Declares --envs, --threads, --batch and --order (`fixed` or `arrival`), with the defaults in
/// `options`.
void add_pool_options(CLI::App& command, PoolOptions& options);

}  // namespace skybody
