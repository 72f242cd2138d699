// NumPy's arrays by its C API: views, copies, and a quick look into an argument. nanobind's arrays
// take several times as long, which counts in calls of a few microseconds.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <initializer_list>
#include <span>

namespace skybody::python {

namespace nb = nanobind;

/// For the module's start. @throws nb::python_error if NumPy is absent or too old
void import_numpy();

/// A writable array over memory that `owner` keeps.
/// @tparam T  bool, float, double, std::uint8_t, std::int32_t or std::uint64_t
template <class T>
nb::object array_view(T* memory, std::span<const std::size_t> shape, nb::handle owner);

/// A fresh array; its memory is in C order and not initialized.
/// @param memory  set to it
template <class T>
nb::object fresh_array(std::span<const std::size_t> shape, T*& memory);

/// The memory of a NumPy array.
template <class T>
struct PlainArray {
  const T* data = nullptr;  ///< null: the object is something else
  std::size_t size = 0;     ///< number of values
  int dimensions = 0;
  const std::ptrdiff_t* shape = nullptr;
};

/// The array, if it is a numpy.ndarray of T in C order, aligned, in the machine's byte order.
template <class T>
PlainArray<T> plain_array(nb::handle object);

/// Consecutive columns of an array, as a view that holds it.
/// @param array  plain_array(object), (n, width)
/// @returns (n,), or (n, count) if `count` is not 1
/// @throws TypeError if `object` is not such an array, ValueError if it is narrower
nb::object columns_view(nb::handle object, const PlainArray<float>& array, std::size_t first,
                        std::size_t count);

/// A result of a bound function: array_view() with a type and dimensions for the stub.
template <class T, int N>
class ArrayView {
 public:
  ArrayView(T* memory, std::initializer_list<std::size_t> shape, nb::handle owner)
      : object_(array_view(memory, std::span(shape.begin(), shape.size()), owner)) {}
  nb::handle release() { return object_.release(); }

 private:
  nb::object object_;
};

}  // namespace skybody::python

template <class T, int N>
struct nanobind::detail::type_caster<skybody::python::ArrayView<T, N>> {
  using Shown = nanobind::ndarray<nanobind::numpy, T, nanobind::ndim<N>>;
  static constexpr auto Name = type_caster<Shown>::Name;
  static handle from_cpp(skybody::python::ArrayView<T, N>&& view, rv_policy, cleanup_list*) {
    return view.release();
  }
};
