// The result of recv(), for Python.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/batch/batch.h"
#include "core/env/compiled_scenario.h"

namespace skybody::python {

/// Keeps the buffer from being recycled as long as this object, or a view of it, lives.
struct ReceivedBatch {
  std::shared_ptr<const Batch> core;
  std::shared_ptr<const CompiledScenario> compiled;
  std::vector<std::int32_t> clipped = {};  ///< per row: action values beyond [-1, 1]; empty: none
};

}  // namespace skybody::python
