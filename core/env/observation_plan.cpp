#include "core/env/observation_plan.h"

#include <cstdio>
#include <string>
#include <string_view>

#include "core/base/system/suggestion.h"
#include "core/model/located_error.h"

namespace skybody {
namespace {

ObservationColumn to_column(const Channel& channel, ColumnSource source) {
  ObservationColumn column;
  column.name = channel.name;
  column.unit = channel.unit;
  column.doc = channel.doc;
  column.type = channel.type;
  column.shape = channel.is_image() ? channel.shape : std::vector<int>{channel.count};
  column.low = channel.low;
  column.high = channel.high;
  column.robot = channel.robot;
  column.privileged = channel.privileged;
  column.source = source;
  return column;
}

std::string range_text(double low, double high) {
  char text[64];
  std::snprintf(text, sizeof text, "%g to %g", low, high);
  return text;
}

/// Start of the name of a task's own column in `observe`.
constexpr std::string_view kOfTask = "task.";

class Planner {
 public:
  Planner(const PluginInstance& task, const std::vector<PluginInstance>& sensors)
      : task_(task), sensors_(sensors) {
    for (std::size_t k = 0; k < task.channels.size(); ++k) {
      plan.columns.push_back(to_column(task.channels[k], {-1, static_cast<int>(k)}));
    }
  }

  void add(const ObservedChannel& observed) {
    if (observed.channel.starts_with(kOfTask)) {
      change(observed);
      return;
    }
    const ColumnSource source = find(observed);
    ObservationColumn column = to_column(channel_of(source), source);
    column.name = observed.name;
    column.privileged |= observed.privileged;
    column.low = observed.low.value_or(column.low);
    column.high = observed.high.value_or(column.high);
    check(observed, column);
    plan.columns.push_back(std::move(column));
  }

  /// @throws LocatedError if the policy has nothing to observe
  void check_observation(const std::vector<ObservedChannel>& observe) const {
    for (const ObservationColumn& column : plan.columns) {
      if (!column.privileged) return;
    }
    throw LocatedError(observe.back().mark,
                       "`observe` makes every column privileged, so that a policy observes nothing;"
                       " leave one to it");
  }

  /// Places every column, the policy's before the privileged ones.
  void place() {
    for (ObservationColumn& column : plan.columns) {
      if (channel_of(column.source).is_image()) {
        place_image(column);
        continue;
      }
      int& size = column.privileged ? plan.privileged_size : plan.observation_size;
      column.first = size;
      size += column.count();
    }
    int next = 0;
    for (const ObservationColumn& column : plan.columns) {
      if (column.source.sensor >= 0) continue;
      plan.is_task_in_place &= place_of(column) == next;
      next += column.count();
    }
    for (const ObservationColumn& column : plan.columns) {
      if (column.image < 0) add_part(column);
    }
  }

  /// Determines the written and the copied parts of a row of observations.
  void place_repeats() {
    std::vector<ValueCopy> copies = task_.task.repeats;
    std::sort(copies.begin(), copies.end(),
              [](const ValueCopy& a, const ValueCopy& b) { return a.to < b.to; });
    plan.row.size = plan.observation_size;
    if (!plan.is_task_in_place) {
      plan.task_copies = std::move(copies);
      copies.clear();
    }
    int next = 0;
    for (const ValueCopy& copy : copies) {
      if (copy.to > next) plan.row.written.push_back({next, copy.to - next});
      next = copy.to + copy.count;
      add_copy(copy);
    }
    if (next < plan.row.size) plan.row.written.push_back({next, plan.row.size - next});
    plan.row.set_pieces();
  }

  ObservationPlan plan;

 private:
  /// Gives a column of the task to the critic alone, with bounds or a name of its own.
  void change(const ObservedChannel& observed) {
    ObservationColumn& column = column_of_task(observed);
    if (!observed.privileged) {
      throw LocatedError(observed.mark, "`" + observed.channel +
                                            "` is a column of the task and observed already; give "
                                            "it to the critic alone with `privileged: true`, or "
                                            "remove the entry");
    }
    if (observed.name != observed.channel) column.name = observed.name;
    column.privileged = true;
    column.low = observed.low.value_or(column.low);
    column.high = observed.high.value_or(column.high);
    check(observed, column);
  }

  /// @throws LocatedError if the task has no such column
  ObservationColumn& column_of_task(const ObservedChannel& observed) {
    std::vector<std::string> known;
    for (ObservationColumn& column : plan.columns) {
      if (column.source.sensor >= 0) continue;
      known.push_back(std::string(kOfTask) +
                      task_.channels[static_cast<std::size_t>(column.source.channel)].name);
      if (known.back() == observed.channel) return column;
    }
    throw LocatedError(observed.mark, "the task has no column `" + observed.channel + "`" +
                                          suggestion(observed.channel, known, "there are"));
  }

  /// Merges consecutive copies into one.
  void add_copy(const ValueCopy& copy) {
    if (!plan.row.copies.empty()) {
      ValueCopy& last = plan.row.copies.back();
      if (last.from + last.count == copy.from && last.to + last.count == copy.to) {
        last.count += copy.count;
        return;
      }
    }
    plan.row.copies.push_back(copy);
  }

  const Channel& channel_of(ColumnSource source) const {
    const PluginInstance& owner =
        source.sensor < 0 ? task_ : sensors_[static_cast<std::size_t>(source.sensor)];
    return owner.channels[static_cast<std::size_t>(source.channel)];
  }

  /// @throws LocatedError if no sensor has such a channel
  ColumnSource find(const ObservedChannel& observed) const {
    std::vector<std::string> known;
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      const std::vector<Channel>& channels = sensors_[s].channels;
      for (std::size_t k = 0; k < channels.size(); ++k) {
        known.push_back(sensors_[s].name + "." + channels[k].name);
        if (known.back() == observed.channel) return {static_cast<int>(s), static_cast<int>(k)};
      }
    }
    const std::string hint = suggestion(observed.channel, known, "there are");
    throw LocatedError(observed.mark, "no sensor has a channel `" + observed.channel + "`" +
                                          (hint.empty() ? "; the scenario has no sensors" : hint));
  }

  void check(const ObservedChannel& observed, const ObservationColumn& column) const {
    for (const ObservationColumn& other : plan.columns) {
      if (&other == &column || other.name != column.name) continue;
      throw LocatedError(observed.mark, "the observation has a column `" + column.name +
                                            "` already; give this one another `name`");
    }
    if (column.privileged && channel_of(column.source).is_image()) {
      throw LocatedError(observed.mark, "`" + column.name +
                                            "` is an image and cannot be privileged: privileged "
                                            "columns are vectors; leave `privileged` out");
    }
    if (column.low <= column.high) return;
    const Channel& own = channel_of(column.source);
    throw LocatedError(
        observed.mark,
        "the bounds of `" + column.name + "` are " + range_text(column.low, column.high) +
            "; give `low` and `high` that fit (declared: " + range_text(own.low, own.high) + ")");
  }

  void place_image(ObservationColumn& column) {
    const PluginInstance& sensor = sensors_[static_cast<std::size_t>(column.source.sensor)];
    const auto first = sensor.channels.begin();
    const std::vector<Channel> before(first, first + column.source.channel);
    column.image = static_cast<int>(plan.images.size());
    const auto index = static_cast<int>(&column - plan.columns.data());
    plan.images.push_back(
        {index, sensor.sensor.images + image_bytes(before), channel_of(column.source).bytes()});
  }

  /// A column's first value within the whole observation.
  int place_of(const ObservationColumn& column) const {
    return column.first + (column.privileged ? plan.observation_size : 0);
  }

  /// The first value of a column at its source.
  int origin_of(const ObservationColumn& column) const {
    const bool is_of_task = column.source.sensor < 0;
    const PluginInstance& owner =
        is_of_task ? task_ : sensors_[static_cast<std::size_t>(column.source.sensor)];
    const auto first = owner.channels.begin();
    const std::vector<Channel> before(first, first + column.source.channel);
    return (is_of_task ? 0 : owner.sensor.output) + value_count(before);
  }

  /// Merges consecutive runs into one part.
  void add_part(const ObservationColumn& column) {
    const bool is_of_task = column.source.sensor < 0;
    if (is_of_task && plan.is_task_in_place) return;
    const ObservationPart part{is_of_task, origin_of(column), place_of(column), column.count()};
    if (!plan.parts.empty()) {
      ObservationPart& last = plan.parts.back();
      const bool follows = last.is_of_task == is_of_task && last.from + last.count == part.from &&
                           last.to + last.count == part.to;
      if (follows) {
        last.count += part.count;
        return;
      }
    }
    plan.parts.push_back(part);
  }

  const PluginInstance& task_;
  const std::vector<PluginInstance>& sensors_;
};

}  // namespace

ObservationPlan plan_observation(const PluginInstance& task,
                                 const std::vector<PluginInstance>& sensors,
                                 const std::vector<ObservedChannel>& observe) {
  Planner planner(task, sensors);
  for (const ObservedChannel& observed : observe) planner.add(observed);
  planner.check_observation(observe);
  planner.place();
  planner.place_repeats();
  return std::move(planner.plan);
}

}  // namespace skybody
