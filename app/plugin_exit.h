// Reports the plugin whose code ends the program.
#pragma once

namespace skybody {

/// Installs the handlers. If a plugin calls exit(), crashes or throws while it is loaded or
/// configured, its name is written to stderr before the program ends: with status 2 after exit(),
/// otherwise by the same signal. A crash while a command runs is reported without a name.
void name_plugins_that_end_the_program();

/// During its life a call of exit(), quick_exit() or _exit() is an error too: only a plugin's step
/// can make it.
class CommandRun {
 public:
  CommandRun();
  ~CommandRun();
  CommandRun(const CommandRun&) = delete;
  CommandRun& operator=(const CommandRun&) = delete;
};

}  // namespace skybody
