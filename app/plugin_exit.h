// Names the plugin whose code ends the program.
#pragma once

namespace skybody {

/// From now on a plugin that calls exit(), crashes or throws while it is loaded or configured is
/// named on stderr before the program ends: with status 2 after exit(), else by the same signal.
void name_plugins_that_end_the_program();

/// While it lasts a call of exit(), quick_exit() or _exit() is an error, too: a plugin's step makes
/// it.
class CommandRun {
 public:
  CommandRun();
  ~CommandRun();
  CommandRun(const CommandRun&) = delete;
  CommandRun& operator=(const CommandRun&) = delete;
};

}  // namespace skybody
