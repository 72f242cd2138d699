#include "core/derivative/transition_records.h"

#include <cstring>

namespace skybody {
namespace {

void copy_rows(const double* from, int count, double* to) {
  std::memcpy(to, from, static_cast<std::size_t>(count) * kGroupLanes * sizeof(double));
}

}  // namespace

TransitionRecords::TransitionRecords(const CompiledScenario& compiled, const DualGroup& dual,
                                     int steps)
    : layout_(compiled.layout()),
      repeat_(compiled.scenario().stepping.action_repeat),
      early_rows_(layout_.params.offset),
      late_first_(layout_.action.offset),
      late_rows_(layout_.last_observation.offset - late_first_),
      body_first_(dual.bodies()),
      body_rows_(dual.body_rows()),
      record_size_(static_cast<std::ptrdiff_t>(early_rows_ + late_rows_ + body_rows_) *
                   kGroupLanes),
      records_(static_cast<std::size_t>(record_size_) *
               static_cast<std::size_t>(steps * (repeat_ + 1))) {}

void TransitionRecords::remember(const StateGroup& group, int t, int k, RecordPart part) {
  double* const record = records_.data() + place(t, k);
  const auto copy = [&](int first, int last) {
    copy_rows(group.reals(first), last - first,
              record + static_cast<std::ptrdiff_t>(first) * kGroupLanes);
  };
  const int q = layout_.q.offset, commands = layout_.rotor_command.offset;
  if (part == RecordPart::kCommands) return copy(commands, early_rows_);
  if (part == RecordPart::kMotion) {
    copy(q, commands);
  } else {
    copy(0, early_rows_);
    copy_rows(group.reals(late_first_), late_rows_,
              record + static_cast<std::ptrdiff_t>(early_rows_) * kGroupLanes);
  }
  if (body_rows_ == 0) return;
  copy_rows(group.bodies(), body_rows_,
            record + static_cast<std::ptrdiff_t>(early_rows_ + late_rows_) * kGroupLanes);
}

void TransitionRecords::show(int t, int k, DualGroup& dual) const {
  const double* const record = records_.data() + place(t, k);
  dual.set_values(0, early_rows_, record);
  dual.set_values(late_first_, late_rows_,
                  record + static_cast<std::ptrdiff_t>(early_rows_) * kGroupLanes);
  dual.set_values(body_first_, body_rows_,
                  record + static_cast<std::ptrdiff_t>(early_rows_ + late_rows_) * kGroupLanes);
}

void TransitionRecords::show_plugin_state(int t, int k, DualGroup& dual) const {
  const Block& b = layout_.plugin_state;
  if (b.size > 0) dual.set_values(b.offset, b.size, row(t, k, b.offset));
}

const double* TransitionRecords::row(int t, int k, int row) const {
  std::ptrdiff_t place_in_record = row;
  if (row >= late_first_) place_in_record = early_rows_ + (row - late_first_);
  if (body_rows_ > 0 && row >= body_first_) {
    place_in_record = early_rows_ + late_rows_ + (row - body_first_);
  }
  return records_.data() + place(t, k) + place_in_record * kGroupLanes;
}

}  // namespace skybody
