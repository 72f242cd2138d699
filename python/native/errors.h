// Which Python exception an error of the engine becomes.
#pragma once

#include <nanobind/nanobind.h>

#include <utility>

#include "core/base/error.h"
#include "core/batch/pool.h"

namespace skybody::python {

namespace nb = nanobind;

/// Calls `work`, where whatever the engine refuses is the fault of an argument: ValueError.
template <class Work>
decltype(auto) rethrow_as_argument_error(Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const BufferInUse&) {
    throw;
  } catch (const StateError&) {
    throw;  // the fault of the moment, not of an argument
  } catch (const Error& e) {
    throw nb::value_error(e.what());
  }
}

}  // namespace skybody::python
