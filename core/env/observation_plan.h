// The columns of an observation, and the sources of their values.
#pragma once

#include <vector>

#include "core/env/observation_column.h"
#include "core/env/plugin_instance.h"
#include "core/env/row_conversion.h"
#include "core/model/scenario.h"

namespace skybody {

/// A run of values that is copied into the observation's values before rows are written.
struct ObservationPart {
  bool is_of_task = false;  ///< from the task's values, else from the sensors' outputs
  int from = 0;             ///< first value of the source
  int to = 0;               ///< first value of the observation
  int count = 0;
};

/// An image of the observation, one buffer of a batch.
struct ObservedImage {
  int column = 0;  ///< index within the columns
  int from = 0;    ///< first byte within an environment's image memory
  int bytes = 0;
};

/// The columns of an observation: the task's channels in order, then those added by `observe`,
/// which also gives columns of the task to the critic alone.
///
/// The values of an environment are the row of observations, which the policy sees, followed by the
/// privileged row. If the task's values are one run of the observation, the task writes them
/// directly to their place. Else, and for sensors, `parts` lists the copies.
struct ObservationPlan {
  std::vector<ObservationColumn> columns;
  std::vector<ObservationPart> parts;
  std::vector<ObservedImage> images;
  bool is_task_in_place = true;  ///< the task's values are the first of the observation
  /// Layout of a row of observations. Repeats of a task in place are copied only at the end,
  /// within rows.
  RowParts row;
  std::vector<ValueCopy> task_copies;  ///< repeats of a task not in place: copied within the task's
                                       ///< values, in lanes
  int observation_size = 0;            ///< values in a row of observations
  int privileged_size = 0;             ///< values in a privileged row

  int size() const { return observation_size + privileged_size; }
};

/// @throws LocatedError at the entry of `observe` if it names no channel of a sensor and no column
///   of the task, reuses a column's name, has a lower bound above the upper bound, makes an image
///   privileged, or leaves nothing to a policy
ObservationPlan plan_observation(const PluginInstance& task,
                                 const std::vector<PluginInstance>& sensors,
                                 const std::vector<ObservedChannel>& observe);

}  // namespace skybody
