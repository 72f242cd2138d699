// What recv() gave, as Python holds it.
#pragma once

#include <memory>

#include "core/batch/batch.h"
#include "core/env/compiled_scenario.h"

namespace skybody::python {

/// Keeps the buffer from being recycled as long as it, or a view of it, lives.
struct ReceivedBatch {
  std::shared_ptr<const Batch> core;
  std::shared_ptr<const CompiledScenario> compiled;
};

}  // namespace skybody::python
