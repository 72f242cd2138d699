// Work that opens plugins, in a child process: their code may end it without ending the program.
#pragma once

#include <functional>

#include "plugins/host/registry.h"

namespace skybody {

/// Does `work` in a child process and writes its output when it is done. Where the code of a plugin
/// ends the child (exit, crash, an exception that nobody catches), the output is dropped and the
/// work is done again in a new child with that plugin's file among the refused ones. Must be called
/// before the program has threads.
/// @param work  returns the exit status; exceptions become messages, as in run_and_report()
/// @returns the exit status
int run_in_child(const std::function<int(const RefusedFiles&)>& work);

}  // namespace skybody
