// Values of the state of many environments as arrays for Python.
#pragma once

#include <string>
#include <vector>

#include "core/env/state_values.h"
#include "python/native/arrays.h"
#include "python/native/errors.h"
#include "python/native/loaded_scenario.h"

namespace skybody::python {

/// A fresh array (*rows, *shape of the value), float64.
/// @param rows  {number of environments}, or {} for a single one
/// @param fill  writes all values: called with a std::vector<double>&
/// @throws ValueError with the nearest paths if there is no such value
template <class Fill>
nb::object state_array(const LoadedScenario& compiled, const std::string& path,
                       std::vector<std::size_t> rows, Fill&& fill) {
  const StateValue& value = rethrow_as_argument_error(
      [&]() -> const StateValue& { return compiled->state_values().at(path); });
  std::vector<std::size_t> shape = std::move(rows);
  shape.insert(shape.end(), value.shape.begin(), value.shape.end());
  std::size_t size = 1;
  for (const std::size_t extent : shape) size *= extent;
  std::vector<double> values(size);
  fill(values);
  return copy_of<double>(values, std::span<const std::size_t>(shape));
}

}  // namespace skybody::python
