// One bit for each lane of every group.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace skybody {

/// Flags that one thread writes while others may read other lanes of the same group: the caller
/// sends an environment while a worker steps its neighbour. The queues hand each flag from thread
/// to thread, so relaxed order suffices.
class AtomicLaneMasks {
 public:
  explicit AtomicLaneMasks(int groups) : flags_(static_cast<std::size_t>(groups)) {}

  /// The lanes of a group whose flag is set.
  std::uint32_t of(int group) const { return at(group).load(std::memory_order_relaxed); }
  /// One writer at a time for each group. Writes only on a change, because neighbouring groups'
  /// flags share a cache line.
  void set(int group, std::uint32_t lanes, bool value) {
    std::atomic<std::uint32_t>& flags = flags_[static_cast<std::size_t>(group)];
    const std::uint32_t before = flags.load(std::memory_order_relaxed);
    const std::uint32_t now = value ? before | lanes : before & ~lanes;
    if (now != before) flags.store(now, std::memory_order_relaxed);
  }
  void clear() {
    for (std::atomic<std::uint32_t>& flags : flags_) flags.store(0, std::memory_order_relaxed);
  }

 private:
  const std::atomic<std::uint32_t>& at(int group) const {
    return flags_[static_cast<std::size_t>(group)];
  }
  std::vector<std::atomic<std::uint32_t>> flags_;
};

}  // namespace skybody
