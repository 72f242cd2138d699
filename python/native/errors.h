// Maps errors of the engine to Python exceptions.
#pragma once

#include <nanobind/nanobind.h>

#include <utility>

#include "core/base/system/error.h"
#include "core/batch/pool.h"

namespace skybody::python {

namespace nb = nanobind;

/// Calls `work`, where any refusal by the engine is an error of an argument: ValueError.
template <class Work>
decltype(auto) rethrow_as_argument_error(Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const BufferInUse&) {
    throw;
  } catch (const StateError&) {
    throw;  // a temporary condition, not an error of an argument
  } catch (const Error& e) {
    throw nb::value_error(e.what());
  }
}

}  // namespace skybody::python
