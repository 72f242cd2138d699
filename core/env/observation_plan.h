// Which columns an observation has, and where the values of each come from.
#pragma once

#include <vector>

#include "core/env/group_rows.h"
#include "core/env/observation_column.h"
#include "core/env/plugin_instance.h"
#include "core/model/scenario.h"

namespace skybody {

/// A run of values that is copied into the observation's values before rows are written.
struct ObservationPart {
  bool is_of_task = false;  ///< from what the task wrote, else from the outputs of the sensors
  int from = 0;             ///< first value there
  int to = 0;               ///< first value of the observation
  int count = 0;
};

/// An image of the observation, one buffer of a batch.
struct ObservedImage {
  int column = 0;  ///< index within the columns
  int from = 0;    ///< first byte within an environment's image memory
  int bytes = 0;
};

/// The columns of an observation: the task's channels in order, then those that `observe` adds.
///
/// The values of an environment are the row of observations, which the policy sees, and after it
/// the privileged row. A task writes its values straight to their place where they are one run;
/// else, and for sensors, `parts` says what is copied.
struct ObservationPlan {
  std::vector<ObservationColumn> columns;
  std::vector<ObservationPart> parts;
  std::vector<ObservedImage> images;
  bool is_task_in_place = true;  ///< the task's values are the first of the observation
  /// Of a row of observations: repeats of a task in place are copied from row to row's end alone.
  RowParts row;
  std::vector<ValueCopy> task_copies;  ///< else they are copied within the task's values, in lanes
  int observation_size = 0;            ///< values of a row of observations
  int privileged_size = 0;             ///< values of a privileged row

  int size() const { return observation_size + privileged_size; }
};

/// @throws LocatedError at the entry of `observe` that names no channel of a sensor, gives a column
///         the name of another one or bounds upside down, or makes an image privileged
ObservationPlan plan_observation(const PluginInstance& task,
                                 const std::vector<PluginInstance>& sensors,
                                 const std::vector<ObservedChannel>& observe);

}  // namespace skybody
