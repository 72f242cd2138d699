#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cstddef>
#include <string>
#include <tuple>
#include <vector>

#include "python/native/bindings.h"
#include "python/native/numpy_array.h"

namespace skybody::python {
namespace {

/// Places of named values in a row.
class InfoColumns {
 public:
  /// @throws ValueError if a place or a number is negative
  explicit InfoColumns(const std::vector<std::tuple<std::string, int, int>>& columns) {
    for (const auto& [name, first, count] : columns) {
      if (first < 0 || count < 0)
        throw nb::value_error(("`" + name + "` has a negative place or number of values").c_str());
      columns_.push_back({nb::str(name.c_str()), static_cast<std::size_t>(first),
                          static_cast<std::size_t>(count)});
    }
  }

  /// All values of rows, as views: in one call, since NumPy's indexing takes longer than a step of
  /// an environment.
  nb::dict of(nb::handle rows) const {
    nb::dict views;
    if (columns_.empty()) return views;
    const PlainArray<float> values = plain_array<float>(rows);
    for (const Column& column : columns_) {
      views[column.name] = columns_view(rows, values, column.first, column.count);
    }
    return views;
  }

 private:
  struct Column {
    nb::str name;
    std::size_t first, count;
  };
  std::vector<Column> columns_;
};

}  // namespace

void bind_info_columns(nb::module_& m) {
  nb::class_<InfoColumns>(
      m, "InfoColumns", "Names of the values in rows: (name, first value, number of values) each.")
      .def(nb::init<const std::vector<std::tuple<std::string, int, int>>&>(), nb::arg("columns"))
      .def("of", &InfoColumns::of, nb::arg("rows"),
           nb::sig("def of(self, rows: numpy.typing.NDArray[numpy.float32])"
                   " -> dict[str, numpy.typing.NDArray[numpy.float32]]"),
           "Views of rows (n, width) float32 in C order: (n,), or (n, count) of several values.\n\n"
           "Raises TypeError on another array, ValueError if a row is shorter.");
}

}  // namespace skybody::python
