// Strict checks of array arguments, and arrays as results: views or fresh copies.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "core/base/math/vec3.h"
#include "python/native/numpy_array.h"

namespace skybody::python {

template <class T>
using Array1 = ArrayView<T, 1>;
template <class T>
using Array2 = ArrayView<T, 2>;

/// The values of an array argument in C order: the array's own memory, or a copy if it is not
/// contiguous. Holds the array; create and destroy it under the GIL.
template <class T>
class Values {
 public:
  std::span<const T> span() const { return span_; }
  std::size_t rows() const { return rows_; }

 private:
  template <class U>
  friend Values<U> read_array(nb::handle, const char*, std::initializer_list<std::int64_t>);
  nb::object plain_;                            ///< a NumPy array whose own memory is read
  nb::ndarray<nb::ro, nb::device::cpu> array_;  ///< any other
  std::vector<T> copy_;
  std::size_t rows_ = 0;
  std::span<const T> span_;
};

/// Reads an array (NumPy, or any CPU object with DLPack or the buffer protocol).
/// @param shape  required shape; -1: any extent
/// @throws TypeError if it is not an array or not of type T (there is no silent conversion);
///         ValueError if its shape differs
template <class T>
Values<T> read_array(nb::handle object, const char* name,
                     std::initializer_list<std::int64_t> shape);

/// Reads a mask: bool or uint8, one value per environment.
std::vector<std::uint8_t> read_mask(nb::handle object, const char* name, std::int64_t size);

/// @throws IndexError if there is no such image
void check_image(int index, std::size_t images);

/// A fresh array with a copy of `values`.
template <class T>
nb::object copy_of(std::span<const T> values, std::span<const std::size_t> shape);
template <class T>
nb::object copy_of(std::span<const T> values, std::initializer_list<std::size_t> shape) {
  return copy_of(values, std::span(shape.begin(), shape.size()));
}
/// A fresh one-dimensional array with a copy of `values`.
template <class T>
nb::object array_of(std::span<const T> values) {
  return copy_of<T>(values, {values.size()});
}

/// A vector as a fresh array: (3,) float64.
inline nb::object vector3(const Vec3<double>& v) {
  const double values[] = {v.x, v.y, v.z};
  return copy_of<double>(values, {3});
}

}  // namespace skybody::python
