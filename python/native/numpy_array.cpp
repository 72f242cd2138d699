#define NPY_NO_DEPRECATED_API NPY_1_7_API_VERSION
#include "python/native/numpy_array.h"

#include <numpy/arrayobject.h>

#include <algorithm>
#include <cstdint>
#include <type_traits>

namespace skybody::python {
namespace {

template <class T>
constexpr int kType = std::is_same_v<T, bool>            ? NPY_BOOL
                      : std::is_same_v<T, float>         ? NPY_FLOAT32
                      : std::is_same_v<T, double>        ? NPY_FLOAT64
                      : std::is_same_v<T, std::uint8_t>  ? NPY_UINT8
                      : std::is_same_v<T, std::int32_t>  ? NPY_INT32
                      : std::is_same_v<T, std::uint64_t> ? NPY_UINT64
                                                         : NPY_NOTYPE;

constexpr std::size_t kMostDimensions = 8;

/// @param memory  null: NumPy allocates
PyObject* make_array(int type, void* memory, std::span<const std::size_t> shape) {
  if (shape.size() > kMostDimensions) throw nb::value_error("an array has too many dimensions");
  npy_intp extents[kMostDimensions];
  std::copy(shape.begin(), shape.end(), extents);
  // Without memory, flags other than 0 would ask for Fortran's order.
  const int flags = memory == nullptr ? 0 : NPY_ARRAY_CARRAY;
  return PyArray_New(&PyArray_Type, static_cast<int>(shape.size()), extents, type, nullptr, memory,
                     0, flags, nullptr);
}

/// @throws nb::python_error if there is no array
nb::object taken(PyObject* array) {
  if (array == nullptr) throw nb::python_error();
  return nb::steal(array);
}

PyArrayObject* as_array(nb::handle object) {
  return reinterpret_cast<PyArrayObject*>(object.ptr());
}

/// The array, which holds the owner of its memory from now on.
nb::object with_owner(PyObject* array, nb::handle owner) {
  nb::object held = taken(array);
  owner.inc_ref();  // passed on, also in case of an error
  if (PyArray_SetBaseObject(as_array(held), owner.ptr()) < 0) throw nb::python_error();
  return held;
}

}  // namespace

void import_numpy() {
  if (_import_array() < 0) throw nb::python_error();
}

template <class T>
nb::object array_view(T* memory, std::span<const std::size_t> shape, nb::handle owner) {
  return with_owner(make_array(kType<T>, memory, shape), owner);
}

template <class T>
nb::object fresh_array(std::span<const std::size_t> shape, T*& memory) {
  nb::object array = taken(make_array(kType<T>, nullptr, shape));
  memory = static_cast<T*>(PyArray_DATA(as_array(array)));
  return array;
}

template <class T>
PlainArray<T> plain_array(nb::handle object) {
  static_assert(sizeof(npy_intp) == sizeof(std::ptrdiff_t));
  if (!PyArray_CheckExact(object.ptr())) return {};
  PyArrayObject* array = as_array(object);
  if (PyArray_TYPE(array) != kType<T> || !PyArray_ISCARRAY_RO(array)) return {};
  return {static_cast<const T*>(PyArray_DATA(array)), static_cast<std::size_t>(PyArray_SIZE(array)),
          PyArray_NDIM(array), PyArray_DIMS(array)};
}

nb::object columns_view(nb::handle object, const PlainArray<float>& array, std::size_t first,
                        std::size_t count) {
  if (array.data == nullptr || array.dimensions != 2) {
    throw nb::type_error("rows are not a two-dimensional float32 array in C order");
  }
  const npy_intp width = array.shape[1];
  if (first + count > static_cast<std::size_t>(width)) {
    throw nb::value_error("a row has fewer values than the columns take");
  }
  npy_intp extents[] = {array.shape[0], static_cast<npy_intp>(count)};
  npy_intp strides[] = {width * static_cast<npy_intp>(sizeof(float)), sizeof(float)};
  PyObject* view = PyArray_New(&PyArray_Type, count == 1 ? 1 : 2, extents, NPY_FLOAT32, strides,
                               const_cast<float*>(array.data) + first, 0,
                               PyArray_FLAGS(as_array(object)) & NPY_ARRAY_WRITEABLE, nullptr);
  return with_owner(view, object);
}

template nb::object array_view(bool*, std::span<const std::size_t>, nb::handle);
template nb::object array_view(float*, std::span<const std::size_t>, nb::handle);
template nb::object array_view(std::uint8_t*, std::span<const std::size_t>, nb::handle);
template nb::object array_view(std::int32_t*, std::span<const std::size_t>, nb::handle);
template nb::object array_view(std::uint64_t*, std::span<const std::size_t>, nb::handle);

template nb::object fresh_array(std::span<const std::size_t>, float*&);
template nb::object fresh_array(std::span<const std::size_t>, double*&);
template nb::object fresh_array(std::span<const std::size_t>, std::uint8_t*&);
template nb::object fresh_array(std::span<const std::size_t>, std::int32_t*&);
template nb::object fresh_array(std::span<const std::size_t>, std::uint64_t*&);

template PlainArray<float> plain_array(nb::handle);
template PlainArray<double> plain_array(nb::handle);
template PlainArray<std::int32_t> plain_array(nb::handle);
template PlainArray<std::uint64_t> plain_array(nb::handle);

}  // namespace skybody::python
