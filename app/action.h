// What a command does, and what the program's exit status says.
#pragma once

#include <functional>

namespace skybody {

/// Exit statuses of the program.
enum ExitStatus : int {
  kExitDone = 0,
  kExitDiffers = 1,  ///< replay: the runs are not the same
  kExitError = 2,    ///< the user's input: command line, files, plugins, places to write to
  kExitBug = 3,      ///< ours
  kExitSignal = 128  ///< plus the signal: 130 after Ctrl-C
};

/// Does the command's work. @returns the exit status
using Action = std::function<int()>;

}  // namespace skybody
