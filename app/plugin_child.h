// Work that opens plugins, in a child process: their code may end it without ending the program.
#pragma once

#include <functional>
#include <string>

#include "plugins/host/registry.h"

namespace skybody {

/// What a child process has left.
struct ChildOutput {
  int status = 0;  ///< exit status
  std::string out, err;
};

/// How long a plugin may take to be loaded or configured in a child [s].
inline constexpr unsigned kPluginTimeout = 30;

/// Does `work` in a child process. Where the code of a plugin ends the child (exit, crash, an
/// exception that nobody catches, a signal, no return within `patience` seconds), the output is
/// dropped and the work is done again in a new child with that plugin's file among the refused
/// ones. Must be called before the program has threads.
/// @param work  returns the exit status; exceptions become messages, as in run_and_report()
ChildOutput output_of_child(const std::function<int(const RefusedFiles&)>& work,
                            unsigned patience = kPluginTimeout);

/// The same; writes the output when the work is done. @returns the exit status
int run_in_child(const std::function<int(const RefusedFiles&)>& work);

}  // namespace skybody
