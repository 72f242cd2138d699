// Distribution of a round's groups among threads: no locks, no allocation.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

namespace skybody {

/// Groups 0 to n-1, cut into one range per thread. A thread works from its own range's start on.
/// The ranges are the same in every round, so the thread's data stays in its processor's caches.
/// When its range is used up, it takes from the end of the longest other range.
class WorkStealingRanges {
 public:
  explicit WorkStealingRanges(int threads) : ranges_(static_cast<std::size_t>(threads)) {}

  /// Opens groups 0 to groups-1, in ranges for the first `threads` threads. All groups of the
  /// previous round must be taken.
  void open(int groups, int threads) {
    const auto bound = [=](int thread) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(groups) * thread / threads);
    };
    for (int t = 0; t < threads; ++t) {
      at(t).store(bound(t) | bound(t + 1) << 32, std::memory_order_seq_cst);
    }
  }

  /// Approximate number of groups not yet taken.
  int left() const {
    int sum = 0;
    for (const Range& range : ranges_) sum += length(range.bounds.load(std::memory_order_seq_cst));
    return sum;
  }

  /// Takes `want(available)` neighbouring groups (at least one).
  /// @param first  receives the first of them
  /// @returns number of groups taken; 0: all are taken
  template <class Want>
  int take(int thread, int& first, Want&& want) {
    while (true) {
      const int whose = length(at(thread).load(std::memory_order_acquire)) > 0 ? thread : longest();
      if (whose < 0) return 0;
      std::uint64_t bounds = at(whose).load(std::memory_order_acquire);
      const int available = length(bounds);
      if (available == 0) continue;  // another thread was faster
      const auto start = static_cast<int>(bounds & 0xffffffffu);
      const bool own = whose == thread;
      const int count = want(available);
      const auto n = static_cast<std::uint64_t>(count);
      const std::uint64_t rest = own ? bounds + n : bounds - (n << 32);
      if (!at(whose).compare_exchange_strong(bounds, rest, std::memory_order_acq_rel)) continue;
      first = own ? start : start + available - count;
      return count;
    }
  }

 private:
  /// First group and the end of the range, in the lower and the upper half.
  struct alignas(64) Range {
    std::atomic<std::uint64_t> bounds{0};
  };
  static int length(std::uint64_t bounds) {
    return static_cast<int>(bounds >> 32) - static_cast<int>(bounds & 0xffffffffu);
  }
  std::atomic<std::uint64_t>& at(int thread) {
    return ranges_[static_cast<std::size_t>(thread)].bounds;
  }
  /// The thread with the longest range; -1: all ranges are empty.
  int longest() const {
    int best = -1, most = 0;
    for (std::size_t k = 0; k < ranges_.size(); ++k) {
      const int l = length(ranges_[k].bounds.load(std::memory_order_relaxed));
      if (l > most) {
        most = l;
        best = static_cast<int>(k);
      }
    }
    return best;
  }

  std::vector<Range> ranges_;
};

}  // namespace skybody
