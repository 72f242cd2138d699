#include "app/plugin_exit.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>

#include "app/action.h"
#include "core/base/breadcrumb.h"

namespace skybody {
namespace {

constexpr std::array kCrashes = {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};

Breadcrumb breadcrumb;
std::array<struct sigaction, kCrashes.size()> previous;

/// Only calls that a handler of signals may make.
void write_text(const char* text) {
  [[maybe_unused]] const ssize_t ignored = write(STDERR_FILENO, text, std::strlen(text));
}

/// Writes "error: FILE HOW PHASE; REMEDY"; does nothing while no plugin's code runs.
/// @returns whether one does
bool name_plugin(const char* how) {
  if (breadcrumb.phase[0] == '\0') return false;
  const std::array texts = {"error: ", static_cast<const char*>(breadcrumb.file), how,
                            static_cast<const char*>(breadcrumb.phase),
                            "; `skybody check` says more\n"};
  for (const char* text : texts) write_text(text);
  return true;
}

pid_t running_command = 0;  ///< the process that runs it; 0: none does

void at_exit() {
  if (name_plugin(": ends the program ")) _exit(kExitError);
  if (running_command != getpid()) return;  // a child has a parent that says it
  write_text(
      "error: something calls exit() before the command is done, most likely a step of a plugin; "
      "`skybody check` says which\n");
  _exit(kExitError);
}

/// Does what the signal would have done: a fault comes again after this, one that was sent would
/// not.
void at_crash(int signal, siginfo_t* info, void*) {
  name_plugin(": crashes ");
  for (std::size_t i = 0; i < kCrashes.size(); ++i) {
    if (kCrashes[i] == signal) sigaction(signal, &previous[i], nullptr);
  }
  if (info->si_code <= 0) raise(signal);  // sent by a process; pending until the handler returns
}

/// Where the handler runs: the plugin may have used up the program's own stack. Sanitizers have
/// made one for theirs.
void make_own_stack() {
  stack_t present{};
  if (sigaltstack(nullptr, &present) != 0 || (present.ss_flags & SS_DISABLE) == 0) return;
  static std::array<char, 1 << 16> memory;
  stack_t own{};
  own.ss_sp = memory.data();
  own.ss_size = memory.size();
  sigaltstack(&own, nullptr);
}

}  // namespace

CommandRun::CommandRun() { running_command = getpid(); }
CommandRun::~CommandRun() { running_command = 0; }

void name_plugins_that_end_the_program() {
  watch_plugins(&breadcrumb);
  std::atexit(at_exit);
  make_own_stack();
  struct sigaction action {};
  action.sa_sigaction = at_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  for (std::size_t i = 0; i < kCrashes.size(); ++i) sigaction(kCrashes[i], &action, &previous[i]);
}

}  // namespace skybody
