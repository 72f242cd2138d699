// Queue of finished groups for the caller: many producers, one consumer, no locks.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

namespace skybody {

/// A ring of (group, lanes). Holds one entry per environment: an environment that has finished is
/// sent again only after its entry was read.
class DoneQueue {
 public:
  explicit DoneQueue(int envs)
      : ring_(std::bit_ceil(static_cast<std::size_t>(envs))), mask_(ring_.size() - 1) {}

  void push(int group, std::uint32_t lanes) {
    const std::uint64_t at = tail_.fetch_add(1, std::memory_order_acq_rel);
    const std::uint64_t entry = (static_cast<std::uint64_t>(group) << 32) | lanes;
    ring_[static_cast<std::size_t>(at) & mask_].store(entry, std::memory_order_seq_cst);
  }

  /// @returns false if the queue is empty
  bool pop(int& group, std::uint32_t& lanes) {
    std::atomic<std::uint64_t>& slot = ring_[head_ & mask_];
    // Sequentially consistent with the caller's sleep flag: a producer that does not see the flag
    // has stored its entry before this load.
    const std::uint64_t entry = slot.load(std::memory_order_seq_cst);
    if (entry == 0) return false;  // lanes are never 0
    slot.store(0, std::memory_order_relaxed);
    ++head_;
    group = static_cast<int>(entry >> 32);
    lanes = static_cast<std::uint32_t>(entry);
    return true;
  }

 private:
  std::vector<std::atomic<std::uint64_t>> ring_;
  std::size_t mask_;
  std::size_t head_ = 0;  ///< used by the consumer only
  alignas(64) std::atomic<std::uint64_t> tail_{0};
};

}  // namespace skybody
