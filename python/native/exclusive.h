// Admits one Python thread at a time to an engine object that is not thread-safe.
#pragma once

#include <atomic>
#include <string>

#include "core/base/system/error.h"

namespace skybody::python {

/// Locks an object for the length of one call.
class Exclusive {
 public:
  /// @throws Error if another thread is inside a call; waiting instead could deadlock with the GIL
  Exclusive(std::atomic<bool>& in_use, const char* what) : in_use_(in_use) {
    if (in_use_.exchange(true, std::memory_order_acquire)) {
      throw Error(std::string("this ") + what +
                  " is in use by another thread: call it from one thread at a time, or make one " +
                  what + " for each thread");
    }
  }
  ~Exclusive() { in_use_.store(false, std::memory_order_release); }
  Exclusive(const Exclusive&) = delete;
  Exclusive& operator=(const Exclusive&) = delete;

 private:
  std::atomic<bool>& in_use_;
};

}  // namespace skybody::python
