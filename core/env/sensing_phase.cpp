#include "core/env/sensing_phase.h"

#include "core/env/plugin_call.h"

namespace skybody {
namespace {

/// @param steps_left  until outputs are read
std::uint64_t steps_to_read(const PluginInstance& sensor, std::int64_t steps_left) {
  return sensor.sensor.has_observed_image ? static_cast<std::uint64_t>(steps_left)
                                          : SKYBODY_NEVER_READ;
}

}  // namespace

void SensingPhase::sense_due(StateGroup& group, const SkybodyLanes& view,
                             std::int64_t steps_left) const {
  for (const PluginInstance& s : model_.of(SKYBODY_SENSOR)) {
    if (is_left_out(s, steps_left)) continue;
    SkybodyLanes v = view;
    v.active = due(s, group, view.active);
    if (v.active != 0) sense(group, v, s, steps_to_read(s, steps_left));
  }
}

void SensingPhase::sense_all(StateGroup& group, const SkybodyLanes& view) const {
  for (const PluginInstance& sensor : model_.of(SKYBODY_SENSOR)) {
    sense(group, view, sensor, steps_to_read(sensor, 0));
  }
}

void SensingPhase::draw_again(StateGroup& group, const SkybodyLanes& view) const {
  for (const PluginInstance& sensor : model_.of(SKYBODY_SENSOR)) {
    if (sensor.sensor.has_observed_image) sense(group, view, sensor, SKYBODY_DRAW_AGAIN);
  }
}

void SensingPhase::sense(StateGroup& group, const SkybodyLanes& view, const PluginInstance& sensor,
                         std::uint64_t steps_to_read) const {
  SkybodyLanes v = view;
  v.images = group.images().bytes() + sensor.sensor.images;
  v.image_stride = 8 * model_.image_words;
  v.steps_to_read = steps_to_read;
  double* const values =
      group.writable(model_.layout().sensors, v.active) + sensor.sensor.output * group.lanes();
  call_plugin(
      sensor.kernels.sense, sensor, group, v,
      [&] { return CallSizes{0, sensor.channel_count(), 0, "channel", nullptr, nullptr, values}; },
      values);
}

}  // namespace skybody
