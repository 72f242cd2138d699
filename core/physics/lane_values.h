// Values of a lane group as code on packs reads them: indexed like an array of Real.
#pragma once

#include "core/base/pack.h"

namespace skybody {

/// Lanes of a group that is stepped in packs: several packs of the widest kind, so that one call
/// serves many environments.
inline constexpr int kGroupLanes = 32;
/// Lanes of the widest pack.
inline constexpr int kWidestPack = 8;
static_assert(kGroupLanes % kWidestPack == 0 && kGroupLanes <= 32, "masks have 32 bits");

/// Values that each lane has of its own: value k of the lanes that `Real` holds.
template <class Real>
class LaneValues {
 public:
  /// @param data  value 0 of the first of these lanes; value k lies k * kGroupLanes further on
  explicit LaneValues(const double* data) : data_(data) {}
  SKYBODY_INLINE Real operator[](int k) const {
    return load_lanes<Real>(data_ + static_cast<std::ptrdiff_t>(k) * kGroupLanes);
  }
  SKYBODY_INLINE LaneValues operator+(int k) const {
    return LaneValues(data_ + static_cast<std::ptrdiff_t>(k) * kGroupLanes);
  }

 private:
  const double* data_;
};

/// Values that all lanes share: one word each.
template <class Real>
class SharedValues {
 public:
  explicit SharedValues(const double* data) : data_(data) {}
  SKYBODY_INLINE Real operator[](int k) const { return Real(data_[k]); }
  SKYBODY_INLINE SharedValues operator+(int k) const { return SharedValues(data_ + k); }

 private:
  const double* data_;
};

}  // namespace skybody
