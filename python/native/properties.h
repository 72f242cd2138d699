// Short forms of frequent declarations of bindings.
#pragma once

#include <nanobind/nanobind.h>

#include <string>
#include <utility>

namespace skybody::python {

namespace nb = nanobind;

/// Adds a property that is an array. @param dtype  NumPy's name of the type of its values
template <class Class, class Get>
void def_array(Class& c, const char* name, const char* dtype, Get&& get, const char* doc) {
  const std::string signature =
      "def " + std::string(name) + "(self) -> numpy.typing.NDArray[numpy." + dtype + "]";
  c.def_prop_ro(name, std::forward<Get>(get), nb::sig(signature.c_str()), doc);
}

/// Adds __reduce__(), which refuses with TypeError.
template <class Class, class Refuse>
void def_unpicklable(Class& c, Refuse&& refuse) {
  c.def("__reduce__", std::forward<Refuse>(refuse),
        nb::sig("def __reduce__(self) -> typing.NoReturn"));
}

/// Makes it a context manager that closes itself. @param name  of the class in Python
template <class Class>
void def_context(Class& c, const char* name) {
  using T = typename Class::Type;
  const std::string signature = "def __enter__(self) -> " + std::string(name);
  c.def(
      "__enter__", [](nb::handle_t<T> self) { return nb::borrow(self); },
      nb::sig(signature.c_str()));
  c.def(
      "__exit__", [](T& self, const nb::args&) { self.close(); },
      nb::sig("def __exit__(self, *exception: object) -> None"));
}

}  // namespace skybody::python
