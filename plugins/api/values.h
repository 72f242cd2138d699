// Views of values in lanes: what plugin code reads and writes without knowing strides.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/pack.h"
#include "core/base/quat.h"
#include "core/base/vec3.h"

namespace skybody {

/// Read-only values of one kind, for the lanes that `Real` holds. Cheap to copy.
template <class Real>
class ConstValues {
 public:
  ConstValues(const double* data, std::size_t stride) : data_(data), stride_(stride) {}

  /// Value `k`. No bounds check: indices come from configure().
  Real operator[](int k) const {
    return load_lanes<Real>(data_ + static_cast<std::size_t>(k) * stride_);
  }
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

/// Values that plugin code may write; lanes that are not being served keep theirs.
template <class Real>
class Values {
 public:
  Values(double* data, std::size_t stride, const MaskOf<Real>& mask)
      : data_(data), stride_(stride), mask_(mask) {}

  /// Value `k` as it is now.
  Real operator[](int k) const {
    return load_lanes<Real>(data_ + static_cast<std::size_t>(k) * stride_);
  }
  Vec3<Real> vec3(int k) const { return {(*this)[k], (*this)[k + 1], (*this)[k + 2]}; }
  Quat<Real> quat(int k) const {
    return {(*this)[k], (*this)[k + 1], (*this)[k + 2], (*this)[k + 3]};
  }
  /// Writes value `k`.
  void set(int k, const Real& value) const {
    store_lanes(data_ + static_cast<std::size_t>(k) * stride_, value, mask_);
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

 private:
  double* data_;
  std::size_t stride_;
  MaskOf<Real> mask_;
};

}  // namespace skybody
