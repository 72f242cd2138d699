// Lanes from all over a group, gathered into one Real. A long kernel that few lanes need runs once
// for the gathered lanes instead of once for each pack that contains one of them.
#pragma once

#include <bit>
#include <cstdint>

#include "core/physics/world/lane_values.h"

namespace skybody {

/// The lanes that one Real holds: neighbours, or any lanes of the group. Has the interface of
/// LaneSlice.
template <class Real>
class LaneList {
 public:
  /// @param first  of a row of lanes
  explicit LaneList(int first) : first_(first), is_row_(true) {}

  /// Removes the lowest lanes from `lanes`, at most as many as Real holds. If fewer are left, the
  /// last one is repeated; repeated places are not in `taken` and are never stored.
  /// @param taken  written: bits of the places that hold a lane
  static LaneList take(std::uint32_t& lanes, std::uint32_t& taken) {
    LaneList list(0);
    list.is_row_ = false;
    taken = 0;
    int lane = 0;
    for (int i = 0; i < kLanesOf<Real>; ++i) {
      if (lanes != 0) {
        lane = std::countr_zero(lanes);
        lanes &= lanes - 1;
        taken |= 1u << i;
      }
      list.lanes_[i] = static_cast<std::uint8_t>(lane);
    }
    return list;
  }

  /// The first lane of a row; 0 for gathered lanes.
  int first() const { return first_; }

  /// Converts bits of places to bits of the group's lanes.
  std::uint32_t in_group(std::uint32_t bits) const {
    if (is_row_) return bits << first_;
    std::uint32_t all = 0;
    for (; bits != 0; bits &= bits - 1) all |= 1u << lanes_[std::countr_zero(bits)];
    return all;
  }

  /// Converts bits of the group's lanes to bits of places. Repeated places follow the lane that
  /// they repeat.
  std::uint32_t of_group(std::uint32_t lanes) const {
    if (is_row_) return lanes >> first_;
    std::uint32_t bits = 0;
    for (int i = 0; i < kLanesOf<Real>; ++i) bits |= (lanes >> lanes_[i] & 1u) << i;
    return bits;
  }

  /// Pointer to value k of a block, for all lanes of the group.
  template <class T>
  static SKYBODY_INLINE T* block(T* values, int k) {
    return values + k * kLaneStride<Real>;
  }
  SKYBODY_INLINE void load(const double* block, int count, Real* out) const {
    if (is_row_) {
#pragma GCC unroll 1
      for (int k = 0; k < count; ++k)
        out[k] = load_lanes<Real>(block + k * kLaneStride<Real> + first_);
      return;
    }
#pragma GCC unroll 1
    for (int k = 0; k < count; ++k) out[k] = gather(block + k * kLaneStride<Real>);
  }
  SKYBODY_INLINE Real load(const double* block) const {
    return is_row_ ? load_lanes<Real>(block + first_) : gather(block);
  }
  /// @param mask  places to write
  SKYBODY_INLINE void store(const Real* values, int count, const MaskOf<Real>& mask,
                            double* block) const {
    if (is_row_) {
#pragma GCC unroll 1
      for (int k = 0; k < count; ++k) {
        store_lanes(block + k * kLaneStride<Real> + first_, values[k], mask);
      }
      return;
    }
    const std::uint32_t bits = bits_from_mask(mask);
#pragma GCC unroll 1
    for (int k = 0; k < count; ++k) {
      alignas(64) double lanes[kLanesOf<Real>];
      store_lanes(lanes, values[k]);
      for (std::uint32_t left = bits; left != 0; left &= left - 1) {
        const int i = std::countr_zero(left);
        block[k * kLaneStride<Real> + lanes_[i]] = lanes[i];
      }
    }
  }

 private:
  SKYBODY_INLINE Real gather(const double* block) const {
    if constexpr (kLanesOf<Real> == 1)
      return block[lanes_[0]];
    else
      return gather_lanes<Real>(block, lanes_);
  }

  int first_;
  bool is_row_;
  std::uint8_t lanes_[kLanesOf<Real>] = {};
};

/// Values stored per lane: value k of the lanes of a list.
template <class Real>
class ListedValues {
 public:
  /// @param data  value 0 of the group's first lane
  /// @param list  must outlive it
  ListedValues(const double* data, const LaneList<Real>& list) : data_(data), list_(&list) {}
  SKYBODY_INLINE Real operator[](int k) const { return list_->load(data_ + k * kLaneStride<Real>); }
  SKYBODY_INLINE ListedValues operator+(int k) const {
    return ListedValues(data_ + k * kLaneStride<Real>, *list_);
  }

 private:
  const double* data_;
  const LaneList<Real>* list_;
};

}  // namespace skybody
