// Runs work that opens plugins in a child process, which their code may end without ending the
// program.
#pragma once

#include <functional>
#include <string>

#include "core/plugin_host/registry.h"

namespace skybody {

/// Results of a child process.
struct ChildOutput {
  int status = 0;  ///< exit status
  std::string out, err;
};

/// Time limit for loading or configuring a plugin in a child [s].
inline constexpr unsigned kPluginTimeout = 30;

/// Runs `work` in a child process. A plugin's code may end the child: exit, a crash, an uncaught
/// exception, a signal, or no return within `patience` seconds. Then the output is dropped, and the
/// work is repeated in a new child that refuses this plugin's file. Must be called before the
/// program has threads.
/// @param work  returns the exit status; exceptions become messages, as in run_and_report()
ChildOutput output_of_child(const std::function<int(const RefusedFiles&)>& work,
                            unsigned patience = kPluginTimeout);

/// The same; writes the output after the work. @returns the exit status
int run_in_child(const std::function<int(const RefusedFiles&)>& work);

}  // namespace skybody
