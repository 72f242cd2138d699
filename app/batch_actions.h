// Actions for measurements: made beforehand, so that making them costs nothing.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"

namespace skybody {

/// Rows of actions for a batch of any size.
class BatchActions {
 public:
  /// hold, zero, random.
  static const std::vector<std::string>& names();

  /// @param name  one of names()   @param rows  the most that next() will be asked for
  /// @throws Error if the hold policy cannot fly the scenario
  BatchActions(const std::string& name, const std::shared_ptr<const CompiledScenario>& compiled,
               int rows);

  /// So many rows; valid until the object goes.
  std::span<const float> next(std::size_t rows);

 private:
  std::size_t width_, rows_;
  std::size_t turn_ = 0;  ///< first row of the next answer
  std::vector<float> table_;
};

}  // namespace skybody
