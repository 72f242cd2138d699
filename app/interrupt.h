// Handles Ctrl-C and SIGTERM as a request to stop after the current step.
#pragma once

namespace skybody {

/// During its life the first such signal only sets a flag; a second one ends the program at once.
/// At most one instance may exist.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// The received signal, or 0.
  static int signal();
};

}  // namespace skybody
