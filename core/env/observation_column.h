// A typed column of the observation.
#pragma once

#include <string>
#include <vector>

#include "core/env/column_type.h"

namespace skybody {

/// The source of a column's values: the task or a sensor.
struct ColumnSource {
  int sensor = -1;  ///< index within plugins(SKYBODY_SENSOR); -1: the task
  int channel = 0;  ///< index within its channels
};

/// A part of the observation with a name, a type and a shape. The columns of a CompiledScenario
/// define the content of batches, spaces, replays and logs.
struct ObservationColumn {
  std::string name;  ///< unique within the observation
  std::string unit;  ///< SI; empty for a pure number
  std::string doc;   ///< meaning of the values; may be empty
  ColumnType type = ColumnType::kFloat32;
  std::vector<int> shape;  ///< {3}: a vector of three values; {48, 64, 3}: an image
  double low = 0.0;        ///< bounds of the values, may be infinite
  double high = 0.0;
  int robot = -1;           ///< robot whose own observation contains it; -1: every robot's
  bool privileged = false;  ///< for the critic only: not in the policy's observation
  ColumnSource source;
  int first = 0;   ///< its first value within the row of observations, or the privileged row
  int image = -1;  ///< index of an image among CompiledScenario::images(); -1: part of a row

  int count() const {
    int product = 1;
    for (const int extent : shape) product *= extent;
    return product;
  }
};

}  // namespace skybody
