// Access to the values of a lane group from code on doubles or packs.
#pragma once

#include "core/base/math/dual.h"
#include "core/base/simd/pack.h"

namespace skybody {

/// Lanes of a group that is stepped in packs: several packs of the widest kind, so that one call
/// serves many environments.
inline constexpr int kGroupLanes = 32;
/// Lanes of the widest pack.
inline constexpr int kWidestPack = 8;
static_assert(kGroupLanes % kWidestPack == 0 && kGroupLanes <= 32, "masks have 32 bits");

/// Distance between the rows of a group. A group of one lane is used with double.
template <class Real>
inline constexpr std::ptrdiff_t kRowStride = kLanesOf<Real> == 1 ? 1 : kGroupLanes;
/// Distance between the values of one lane. Dual numbers take two rows each: first the values, then
/// the tangents.
template <class Real>
inline constexpr std::ptrdiff_t kLaneStride = kRowsOf<Real>* kRowStride<Real>;

/// Values stored per lane: value k of the lanes that `Real` holds.
template <class Real>
class LaneValues {
 public:
  /// @param data  value 0 of the first of these lanes
  explicit LaneValues(const double* data) : data_(data) {}
  SKYBODY_INLINE Real operator[](int k) const {
    return load_rows<Real>(data_ + k * kLaneStride<Real>, kRowStride<Real>);
  }
  SKYBODY_INLINE LaneValues operator+(int k) const {
    return LaneValues(data_ + k * kLaneStride<Real>);
  }

 private:
  const double* data_;
};

/// Values of plain lanes as constant dual numbers: parameters, which are not differentiated.
template <class Real>
class ConstantValues {
 public:
  explicit ConstantValues(const double* data) : values_(data) {}
  SKYBODY_INLINE Real operator[](int k) const { return Real(values_[k]); }
  SKYBODY_INLINE ConstantValues operator+(int k) const { return ConstantValues(values_ + k); }

 private:
  explicit ConstantValues(const LaneValues<ValueOf<Real>>& values) : values_(values) {}

  LaneValues<ValueOf<Real>> values_;
};

/// Held inputs of the lanes that `Real` holds.
template <class Real>
class HeldLanes {
 public:
  /// @param held   starts of the group's blocks, in the order of SkybodyHeldInput; null: no effect
  ///               holds this input
  /// @param first  of the lanes, within the group
  HeldLanes(const double* const* held, int first) : held_(held), first_(first) {}
  SKYBODY_INLINE bool has(int input) const { return held_[input] != nullptr; }
  /// All values of an input; requires has(input).
  SKYBODY_INLINE LaneValues<Real> operator[](int input) const {
    return LaneValues<Real>(held_[input] + first_);
  }

 private:
  const double* const* held_;
  int first_;
};

/// One value in each lane of the widest pack. Packs of any kind load it directly as an operand,
/// without an instruction that broadcasts one word.
struct alignas(kWidestPack * sizeof(double)) WideValue {
  double lanes[kWidestPack];

  explicit WideValue(double value) {
    for (double& lane : lanes) lane = value;
  }
};

/// Values that all lanes share.
template <class Real>
class SharedValues {
 public:
  explicit SharedValues(const WideValue* data) : data_(data) {}
  SKYBODY_INLINE Real operator[](int k) const { return load_lanes<Real>(data_[k].lanes); }
  SKYBODY_INLINE SharedValues operator+(int k) const { return SharedValues(data_ + k); }

 private:
  const WideValue* data_;
};

/// Stands for a mask with all lanes set: stores need not read the old values.
struct AllLanes {};

/// Location of the lanes of one Real in the blocks of a group.
template <class Real>
class LaneSlice {
 public:
  /// @param first  of the lanes, within the group
  SKYBODY_INLINE LaneSlice(int first) : first_(first) {}

  /// Converts bits of these lanes to bits of the group's lanes, and back. The way back keeps higher
  /// lanes as higher bits.
  std::uint32_t in_group(std::uint32_t bits) const { return bits << first_; }
  std::uint32_t of_group(std::uint32_t lanes) const { return lanes >> first_; }

  /// Pointer to value k of a block, for all lanes of the group.
  static SKYBODY_INLINE double* block(double* values, int k) {
    return values + k * kLaneStride<Real>;
  }
  /// Value k of a block.
  template <class T>
  SKYBODY_INLINE T* at(T* block, int k) const {
    return block + k * kLaneStride<Real> + first_;
  }
  SKYBODY_INLINE Real load(const double* block, int k) const {
    return load_rows<Real>(at(block, k), kRowStride<Real>);
  }
  SKYBODY_INLINE void load(const double* block, int count, Real* out) const {
    for (int k = 0; k < count; ++k) out[k] = load(block, k);
  }
  /// @param mask  lanes to write, or AllLanes
  template <class Mask>
  SKYBODY_INLINE void store(const Real* values, int count, const Mask& mask, double* block) const {
    for (int k = 0; k < count; ++k) put(values[k], mask, at(block, k));
  }
  static SKYBODY_INLINE void put(const Real& value, const MaskOf<Real>& mask, double* p) {
    store_rows(p, kRowStride<Real>, value, mask);
  }
  static SKYBODY_INLINE void put(const Real& value, AllLanes, double* p) {
    if constexpr (kIsDual<Real>) {
      store_rows(p, kRowStride<Real>, value, MaskOf<Real>(true));
    } else {
      store_lanes(p, value);
    }
  }

 private:
  int first_;
};

}  // namespace skybody
