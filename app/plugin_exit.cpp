#include "app/plugin_exit.h"

#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>

#include "app/command_work.h"
#include "core/base/system/plugin_call_trace.h"

namespace skybody {
namespace {

constexpr std::array kCrashes = {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};

PluginCallTrace trace;
std::array<struct sigaction, kCrashes.size()> previous;

/// Uses only functions that are safe in signal handlers.
void write_text(const char* text) {
  [[maybe_unused]] const ssize_t ignored = write(STDERR_FILENO, text, std::strlen(text));
}

/// Writes "error: FILE HOW PHASE; REMEDY"; does nothing while no plugin's code runs.
/// @returns whether a plugin's code runs
bool name_plugin(const char* how) {
  if (trace.phase[0] == '\0') return false;
  const std::array texts = {"error: ", static_cast<const char*>(trace.file), how,
                            static_cast<const char*>(trace.phase), "; `skybody check` says more\n"};
  for (const char* text : texts) write_text(text);
  return true;
}

std::atomic<pid_t> running_command = 0;  ///< process of the running command; 0: none

/// Ends the process, bypassing the _exit() below.
[[noreturn]] void end_process(int status) {
  while (true) syscall(SYS_exit_group, status);
}

/// Ends the program with an error if only a plugin can have requested its end.
/// @param function  the function that was called
void refuse_end(const char* function) {
  if (name_plugin(": ends the program ")) end_process(kExitError);
  if (running_command != getpid()) return;  // in a child the parent reports it
  const std::array texts = {"error: something calls ", function,
                            "() before the command is done, most likely a step of a plugin; "
                            "`skybody check` says which\n"};
  for (const char* text : texts) write_text(text);
  end_process(kExitError);
}

void at_exit() { refuse_end("exit"); }
void at_quick_exit() { refuse_end("quick_exit"); }

/// Restores the signal's default action. A fault occurs again after the handler returns; a sent
/// signal would not, so it is raised.
void at_crash(int signal, siginfo_t* info, void*) {
  if (!name_plugin(": crashes ") && running_command == getpid()) {
    write_text(
        "error: the program crashes, most likely in a step of a plugin; `skybody check` says "
        "which\n");
  }
  for (std::size_t i = 0; i < kCrashes.size(); ++i) {
    if (kCrashes[i] == signal) sigaction(signal, &previous[i], nullptr);
  }
  if (info->si_code <= 0) raise(signal);  // sent by a process; pending until the handler returns
}

/// Stack for the handler: the plugin may have exhausted the program's own. Sanitizers have already
/// set one.
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
  watch_plugins(&trace);
  std::atexit(at_exit);
  std::at_quick_exit(at_quick_exit);
  make_own_stack();
  struct sigaction action {};
  action.sa_sigaction = at_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  for (std::size_t i = 0; i < kCrashes.size(); ++i) sigaction(kCrashes[i], &action, &previous[i]);
}

}  // namespace skybody

/// Replaces the C library's function, which would end the program as if it had succeeded: the
/// loader prefers a program's own symbols, for plugins as well. Only `skybody check` detects a
/// plugin that makes the system call itself, since its parent process sees that the work was not
/// done.
extern "C" __attribute__((visibility("default"), noreturn)) void _exit(int status) {
  skybody::refuse_end("_exit");
  skybody::end_process(status);
}
extern "C" __attribute__((visibility("default"), noreturn)) void _Exit(int status) {
  skybody::refuse_end("_Exit");
  skybody::end_process(status);
}
