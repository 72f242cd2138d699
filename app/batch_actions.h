// Actions for measurements, computed in advance so that they cost no time in the measurement.
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
  /// Names of the action sources: hold, zero, random.
  static const std::vector<std::string>& names();

  /// @param name  one of names()   @param rows  largest argument of next()
  /// @throws Error if the hold policy cannot fly the scenario
  BatchActions(const std::string& name, const std::shared_ptr<const CompiledScenario>& compiled,
               int rows);

  /// The given number of rows; valid during this object's life.
  std::span<const float> next(std::size_t rows);

 private:
  std::size_t width_, rows_;
  std::size_t turn_ = 0;  ///< first row of the next result
  std::vector<float> table_;
};

}  // namespace skybody
