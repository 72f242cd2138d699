// Ctrl-C and SIGTERM as a request to stop after the present step.
#pragma once

namespace skybody {

/// While it lives, the first such signal only sets a flag; a second one ends the program at once.
/// One at a time.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// The signal that came, or 0.
  static int signal();
};

}  // namespace skybody
