// Processors of this machine, for pinning threads.
#pragma once

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <numeric>
#include <thread>
#include <vector>

namespace skybody {

/// Processors that this process may use; never empty.
inline std::vector<int> allowed_processors() {
  std::vector<int> out;
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0) {
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (CPU_ISSET(cpu, &set)) out.push_back(cpu);
    }
  }
  if (out.empty()) {  // the machine has more processors than a cpu_set_t holds
    out.resize(std::max(1u, std::thread::hardware_concurrency()));
    std::iota(out.begin(), out.end(), 0);
  }
  return out;
}

/// Pins a thread to one processor. @returns false if the system refuses: the thread is not pinned
inline bool pin_thread(std::thread& thread, int processor) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(processor, &set);
  return pthread_setaffinity_np(thread.native_handle(), sizeof(set), &set) == 0;
}

}  // namespace skybody
