// Environments that were sent and wait until the rest of their lane group is sent, too.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace skybody {

/// A kernel costs the same for one lane of a group as for all of them. In batches smaller than the
/// pool, groups would fall into ever smaller parts; waiting keeps them whole. For one thread.
class WaitingLanes {
 public:
  explicit WaitingLanes(int groups) : lanes_(static_cast<std::size_t>(groups)) {
    groups_.reserve(lanes_.size());
  }

  /// Number of environments that wait.
  int count() const { return count_; }

  /// @param lane  one bit
  void hold(int group, std::uint32_t lane) {
    std::uint32_t& lanes = lanes_[static_cast<std::size_t>(group)];
    if (lanes == 0) groups_.push_back(group);
    lanes |= lane;
    ++count_;
  }

  /// Passes groups with `is_due(group, lanes)` to `start(group, lanes)`, in order of arrival.
  template <class IsDue, class Start>
  void release(IsDue&& is_due, Start&& start) {
    std::erase_if(groups_, [&](int group) {
      const std::uint32_t lanes = lanes_[static_cast<std::size_t>(group)];
      if (!is_due(group, lanes)) return false;
      take(group);
      start(group, lanes);
      return true;
    });
  }

  /// Passes the group with the most waiting lanes to `start(group, lanes)`. There must be one.
  template <class Start>
  void release_fullest(Start&& start) {
    const auto waiting = [this](int group) {
      return std::popcount(lanes_[static_cast<std::size_t>(group)]);
    };
    const auto fullest = std::max_element(groups_.begin(), groups_.end(),
                                          [&](int a, int b) { return waiting(a) < waiting(b); });
    const int group = *fullest;
    groups_.erase(fullest);
    start(group, take(group));
  }

 private:
  std::uint32_t take(int group) {
    const std::uint32_t lanes = std::exchange(lanes_[static_cast<std::size_t>(group)], 0u);
    count_ -= std::popcount(lanes);
    return lanes;
  }

  std::vector<std::uint32_t> lanes_;  ///< waiting lanes of each group
  std::vector<int> groups_;           ///< groups with waiting lanes, oldest first
  int count_ = 0;
};

}  // namespace skybody
