#include "python/native/arrays.h"

#include <algorithm>
#include <string>

namespace skybody::python {
namespace {

using AnyArray = nb::ndarray<nb::ro, nb::device::cpu>;

std::string type_name(nb::dlpack::dtype type) {
  const char* kind = "kind " /* of DLPack */;
  switch (static_cast<nb::dlpack::dtype_code>(type.code)) {
    case nb::dlpack::dtype_code::Int:
      kind = "int";
      break;
    case nb::dlpack::dtype_code::UInt:
      kind = "uint";
      break;
    case nb::dlpack::dtype_code::Float:
      kind = "float";
      break;
    case nb::dlpack::dtype_code::Bfloat:
      kind = "bfloat";
      break;
    case nb::dlpack::dtype_code::Complex:
      kind = "complex";
      break;
    case nb::dlpack::dtype_code::Bool:
      return "bool";
    default:
      break;
  }
  return kind + std::to_string(type.bits);
}

AnyArray to_array(nb::handle object, const char* name, const std::string& wanted) {
  AnyArray array;
  if (object.is_none() || !nb::try_cast(object, array, false)) {
    throw nb::type_error((std::string(name) + " is of type " +
                          nb::type_name(object.type()).c_str() + "; expected an array of " +
                          wanted + " on the CPU, such as numpy.asarray(" + name + ", dtype=numpy." +
                          wanted + ")")
                             .c_str());
  }
  return array;
}

[[noreturn]] void refuse_type(const AnyArray& array, const char* name, const std::string& wanted) {
  throw nb::type_error((std::string(name) + " has dtype " + type_name(array.dtype()) +
                        "; expected " + wanted + ": convert with .astype(numpy." + wanted + ")")
                           .c_str());
}

std::string shape_text(const AnyArray& array) {
  std::string text = "(";
  for (std::size_t k = 0; k < array.ndim(); ++k) {
    text += (k == 0 ? "" : ", ") + std::to_string(array.shape(k));
  }
  return text + (array.ndim() == 1 ? ",)" : ")");
}

std::string shape_text(std::initializer_list<std::int64_t> shape) {
  std::string text = "(";
  for (const std::int64_t extent : shape) {
    text += (text.size() == 1 ? "" : ", ") + (extent < 0 ? "n" : std::to_string(extent));
  }
  return text + (shape.size() == 1 ? ",)" : ")");
}

void check_shape(const AnyArray& array, const char* name,
                 std::initializer_list<std::int64_t> wanted) {
  bool fits = array.ndim() == wanted.size();
  for (std::size_t k = 0; fits && k < wanted.size(); ++k) {
    const std::int64_t extent = wanted.begin()[k];
    fits = extent < 0 || extent == static_cast<std::int64_t>(array.shape(k));
  }
  if (!fits) {
    throw nb::value_error(
        (std::string(name) + " has shape " + shape_text(array) + "; expected " + shape_text(wanted))
            .c_str());
  }
}

bool is_contiguous(const AnyArray& array) {
  std::int64_t expected = 1;
  for (std::size_t k = array.ndim(); k-- > 0;) {
    if (array.shape(k) != 1 && array.stride(k) != expected) return false;
    expected *= static_cast<std::int64_t>(array.shape(k));
  }
  return true;
}

bool has_shape(int dimensions, const std::ptrdiff_t* shape,
               std::initializer_list<std::int64_t> wanted) {
  return static_cast<std::size_t>(dimensions) == wanted.size() &&
         std::equal(wanted.begin(), wanted.end(), shape,
                    [](std::int64_t w, std::ptrdiff_t extent) { return w < 0 || w == extent; });
}

/// Values of a one- or two-dimensional array in C order.
template <class T>
std::vector<T> gather(const AnyArray& array) {
  const auto* data = static_cast<const T*>(array.data());
  const std::size_t columns = array.ndim() == 2 ? array.shape(1) : 1;
  const std::int64_t across = array.ndim() == 2 ? array.stride(1) : 0;
  std::vector<T> values;
  values.reserve(array.size());
  for (std::size_t row = 0; row < array.shape(0); ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      values.push_back(data[static_cast<std::int64_t>(row) * array.stride(0) +
                            static_cast<std::int64_t>(column) * across]);
    }
  }
  return values;
}

}  // namespace

template <class T>
Values<T> read_array(nb::handle object, const char* name,
                     std::initializer_list<std::int64_t> shape) {
  Values<T> values;
  if (const auto plain = plain_array<T>(object);
      plain.data != nullptr && has_shape(plain.dimensions, plain.shape, shape)) {
    values.plain_ = nb::borrow(object);
    values.rows_ = static_cast<std::size_t>(plain.shape[0]);
    values.span_ = {plain.data, plain.size};
    return values;
  }
  const std::string wanted = type_name(nb::dtype<T>());
  values.array_ = to_array(object, name, wanted);
  const AnyArray& array = values.array_;
  if (array.dtype() != nb::dtype<T>()) refuse_type(array, name, wanted);
  check_shape(array, name, shape);
  values.rows_ = array.shape(0);
  if (array.size() == 0) return values;
  if (is_contiguous(array)) {
    values.span_ = {static_cast<const T*>(array.data()), array.size()};
  } else {
    values.copy_ = gather<T>(array);
    values.span_ = values.copy_;
  }
  return values;
}

template Values<float> read_array(nb::handle, const char*, std::initializer_list<std::int64_t>);
template Values<double> read_array(nb::handle, const char*, std::initializer_list<std::int64_t>);
template Values<std::int32_t> read_array(nb::handle, const char*,
                                         std::initializer_list<std::int64_t>);
template Values<std::uint64_t> read_array(nb::handle, const char*,
                                          std::initializer_list<std::int64_t>);

std::vector<std::uint8_t> read_mask(nb::handle object, const char* name, std::int64_t size) {
  const AnyArray array = to_array(object, name, "bool");
  if (array.dtype() != nb::dtype<bool>() && array.dtype() != nb::dtype<std::uint8_t>()) {
    refuse_type(array, name, "bool");
  }
  check_shape(array, name, {size});
  return gather<std::uint8_t>(array);
}

void check_image(int index, std::size_t images) {
  if (index >= 0 && static_cast<std::size_t>(index) < images) return;
  throw nb::index_error(
      ("image " + std::to_string(index) + " of " + std::to_string(images)).c_str());
}

template <class T>
nb::object copy_of(std::span<const T> values, std::span<const std::size_t> shape) {
  T* memory = nullptr;
  nb::object array = fresh_array(shape, memory);
  std::copy(values.begin(), values.end(), memory);
  return array;
}

template nb::object copy_of(std::span<const float>, std::span<const std::size_t>);
template nb::object copy_of(std::span<const double>, std::span<const std::size_t>);
template nb::object copy_of(std::span<const std::uint8_t>, std::span<const std::size_t>);
template nb::object copy_of(std::span<const std::uint64_t>, std::span<const std::size_t>);
template nb::object copy_of(std::span<const int>, std::span<const std::size_t>);

}  // namespace skybody::python
