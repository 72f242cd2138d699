// The work of a command, and the program's exit statuses.
#pragma once

#include <functional>

namespace skybody {

/// Exit statuses of the program.
enum ExitStatus : int {
  kExitDone = 0,
  kExitDiffers = 1,  ///< replay: the runs differ
  kExitError = 2,  ///< an error in the user's input: command line, files, plugins, output locations
  kExitBug = 3,    ///< a bug in Skybody
  kExitSignal = 128  ///< plus the signal: 130 after Ctrl-C
};

/// The work of a command. @returns the exit status
using Action = std::function<int()>;

}  // namespace skybody
