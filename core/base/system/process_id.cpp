#include "core/base/system/process_id.h"

#include <pthread.h>
#include <unistd.h>

#include <atomic>

namespace skybody {
namespace {

std::atomic<int> current{0};

void renew() { current.store(getpid(), std::memory_order_relaxed); }

}  // namespace

int process_id() {
  static const bool watches_forks = [] {
    renew();
    return pthread_atfork(nullptr, nullptr, &renew) == 0;
  }();
  return watches_forks ? current.load(std::memory_order_relaxed) : getpid();
}

}  // namespace skybody
