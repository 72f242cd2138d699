// Views of values in lanes. They hide the strides from plugin code.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/math/dual.h"
#include "core/base/math/quat.h"
#include "core/base/math/vec3.h"
#include "core/base/simd/pack.h"
#include "core/plugin_abi/abi.h"

namespace skybody {

/// Number of values of a view; stored in checked mode only, and never for packs.
template <class Real>
class Bounds {
 public:
  Bounds() = default;
  Bounds(SkybodyChecks*, const char*, int) {}

 protected:
  Bounds narrowed(const char*, int) const { return {}; }
  template <class T>
  T* place(T* data, std::size_t stride, int k) const {
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(k) * kRowsOf<Real>;
    return data + row * static_cast<std::ptrdiff_t>(stride);
  }
};

template <>
class Bounds<double> {
 public:
  Bounds() = default;
  Bounds(SkybodyChecks* checks, const char* name, int size)
      : checks_(checks), name_(name), size_(size) {}

 protected:
  Bounds narrowed(const char* name, int size) const { return {checks_, name, size}; }
  template <class T>
  T* place(T* data, std::size_t stride, int k) const {
    if (checks_ != nullptr && (k < 0 || k >= size_)) return note(k);
    return data + static_cast<std::ptrdiff_t>(k) * static_cast<std::ptrdiff_t>(stride);
  }

 private:
  __attribute__((noinline, cold)) double* note(int k) const {
    if (checks_->what == nullptr) {
      checks_->what = name_;
      checks_->index = k;
      checks_->size = size_;
    }
    return &checks_->nothing;
  }

  SkybodyChecks* checks_ = nullptr;
  const char* name_ = "";
  int size_ = 0;
};

/// Read-only values of one kind, for the lanes that `Real` holds. Cheap to copy.
template <class Real>
class ConstValues : private Bounds<Real> {
 public:
  ConstValues(const double* data, std::size_t stride, const Bounds<Real>& bounds = {})
      : Bounds<Real>(bounds), data_(data), stride_(stride) {}

  /// Value `k`. Bounds are checked in checked mode only: indices come from configure().
  Real operator[](int k) const { return load_rows<Real>(this->place(data_, stride_, k), stride_); }
  /// Values k, k+1, k+2 as a vector.
  Vec3<Real> vec3(int k) const { return {(*this)[k], (*this)[k + 1], (*this)[k + 2]}; }
  /// Values k..k+3 as a quaternion w x y z.
  Quat<Real> quat(int k) const {
    return {(*this)[k], (*this)[k + 1], (*this)[k + 2], (*this)[k + 3]};
  }

 private:
  const double* data_;
  std::size_t stride_;
};

/// Whether the values declared by Setup::repeat() need not be written.
template <class Real>
inline constexpr bool kLeavesRepeats = kLanesOf<Real> > 1 && !kIsDual<Real>;

/// Writable values; lanes that are not served keep theirs.
template <class Real>
class Values : private Bounds<Real> {
 public:
  Values(double* data, std::size_t stride, const MaskOf<Real>& mask,
         const Bounds<Real>& bounds = {})
      : Bounds<Real>(bounds), data_(data), stride_(stride), mask_(mask) {}

  /// Current value `k`.
  Real operator[](int k) const { return load_rows<Real>(this->place(data_, stride_, k), stride_); }
  /// Current values k, k+1, k+2.
  Vec3<Real> vec3(int k) const { return {(*this)[k], (*this)[k + 1], (*this)[k + 2]}; }
  /// Current values k..k+3 as a quaternion w x y z.
  Quat<Real> quat(int k) const {
    return {(*this)[k], (*this)[k + 1], (*this)[k + 2], (*this)[k + 3]};
  }
  /// Writes value `k`.
  void set(int k, const Real& value) const {
    store_rows(this->place(data_, stride_, k), stride_, value, mask_);
  }
  /// Writes values k, k+1, k+2.
  void set(int k, const Vec3<Real>& v) const {
    set(k, v.x);
    set(k + 1, v.y);
    set(k + 2, v.z);
  }
  /// Writes values k..k+3 as w x y z.
  void set(int k, const Quat<Real>& q) const {
    set(k, q.w);
    set(k + 1, q.x);
    set(k + 2, q.y);
    set(k + 3, q.z);
  }
  /// A view of values from `first` on, renumbered from 0 to count - 1.
  /// @param name  name of the values for checked mode: a text that outlives the view
  Values part(int first, int count, const char* name) const {
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(first) * kRowsOf<Real>;
    return {data_ + row * static_cast<std::ptrdiff_t>(stride_), stride_, mask_,
            this->narrowed(name, count)};
  }

 private:
  double* data_;
  std::size_t stride_;
  MaskOf<Real> mask_;
};

}  // namespace skybody
