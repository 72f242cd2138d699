// Queue of groups that wait for a worker: one producer, many consumers, no locks, no allocation.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

namespace skybody {

/// A ring of group numbers. One thread calls push(); any thread may call take(). Holds as many
/// entries as there are groups: a group is pushed again only after it was taken.
class WorkQueue {
 public:
  explicit WorkQueue(int groups)
      : ring_(std::bit_ceil(static_cast<std::size_t>(groups) + 1)), mask_(ring_.size() - 1) {}

  /// Writes an entry that take() does not see before publish().
  void push(int group) { at(next_++).store(group, std::memory_order_relaxed); }
  void publish() { tail_.store(next_, std::memory_order_seq_cst); }

  bool empty() const {
    return head_.load(std::memory_order_relaxed) >= tail_.load(std::memory_order_seq_cst);
  }
  /// Approximate number of waiting entries.
  std::uint64_t size() const {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    return tail > head ? tail - head : 0;
  }

  /// Takes the first `want(groups, available)` entries (0: takes none).
  /// @param groups  room for `most`
  /// @returns number of entries taken
  template <class Want>
  int take(int* groups, int most, Want&& want) {
    std::uint64_t head = head_.load(std::memory_order_acquire);
    for (;;) {
      const std::uint64_t tail = tail_.load(std::memory_order_acquire);
      if (head >= tail) return 0;
      // Read before the claim: an entry can be overwritten only after the head has moved past it,
      // and then the claim fails.
      const int available =
          static_cast<int>(std::min<std::uint64_t>(tail - head, static_cast<std::uint64_t>(most)));
      for (int k = 0; k < available; ++k) {
        groups[k] = at(head + static_cast<std::uint64_t>(k)).load(std::memory_order_relaxed);
      }
      const int count = want(groups, available);
      if (count == 0) return 0;
      if (head_.compare_exchange_weak(head, head + static_cast<std::uint64_t>(count),
                                      std::memory_order_acq_rel, std::memory_order_acquire)) {
        return count;
      }
    }
  }

 private:
  std::atomic<std::int32_t>& at(std::uint64_t k) {
    return ring_[static_cast<std::size_t>(k) & mask_];
  }
  std::vector<std::atomic<std::int32_t>> ring_;
  std::size_t mask_;
  std::uint64_t next_ = 0;  ///< used by the producer only
  alignas(64) std::atomic<std::uint64_t> head_{0};
  alignas(64) std::atomic<std::uint64_t> tail_{0};
};

}  // namespace skybody
