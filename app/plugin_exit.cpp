#include "app/plugin_exit.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>

#include "app/command.h"
#include "plugins/host/breadcrumb.h"

namespace skybody {
namespace {

constexpr std::array kCrashes = {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};

Breadcrumb breadcrumb;
std::array<struct sigaction, kCrashes.size()> previous;

/// Only calls that a handler of signals may make.
void write_text(const char* text) {
  [[maybe_unused]] const ssize_t ignored = write(STDERR_FILENO, text, std::strlen(text));
}

/// Writes "error: FILE HOW PHASE"; does nothing while no plugin's code runs.
/// @returns whether one does
bool name_plugin(const char* how) {
  if (breadcrumb.phase[0] == '\0') return false;
  const std::array<const char*, 5> texts = {"error: ", breadcrumb.file, how, breadcrumb.phase,
                                            "\n"};
  for (const char* text : texts) write_text(text);
  return true;
}

void at_exit() {
  if (name_plugin(": ends the program ")) _exit(kExitError);
}

/// The signal comes again after this, and does what it would have done.
void at_crash(int signal) {
  name_plugin(": crashes ");
  for (std::size_t i = 0; i < kCrashes.size(); ++i) {
    if (kCrashes[i] == signal) sigaction(signal, &previous[i], nullptr);
  }
}

}  // namespace

void name_plugins_that_end_the_program() {
  watch_plugins(&breadcrumb);
  std::atexit(at_exit);
  struct sigaction action {};
  action.sa_handler = at_crash;
  for (std::size_t i = 0; i < kCrashes.size(); ++i) sigaction(kCrashes[i], &action, &previous[i]);
}

}  // namespace skybody
