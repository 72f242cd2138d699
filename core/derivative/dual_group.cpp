#include "core/derivative/dual_group.h"

#include <algorithm>
#include <cstring>

namespace skybody {

DualGroup::DualGroup(const CompiledScenario& compiled)
    : layout_(compiled.layout()),
      observation_(layout_.words),
      observed_(compiled.task().channel_count()),
      rows_(reward() + 1 +
            (compiled.model().physics->bodies_are_coordinates()
                 ? 0
                 : 13 * static_cast<int>(compiled.world().bodies.size()))),
      bodies_(compiled.model().physics->bodies_are_coordinates() ? layout_.q.offset : reward() + 1),
      data_(static_cast<std::size_t>(2 * rows_) * kGroupLanes) {
  int most = 0;
  for (const SkybodyKind kind : {SKYBODY_CONTROLLER, SKYBODY_EFFECT, SKYBODY_TASK}) {
    for (const PluginInstance& p : compiled.plugins(kind)) most = std::max(most, p.memory.scratch);
  }
  scratch_ = AlignedArray<double>(static_cast<std::size_t>(2 * most) * kGroupLanes);
}

void DualGroup::set_values(int row, int count, const double* values) {
  for (int k = 0; k < count; ++k) {
    std::memcpy(value(row + k), values + static_cast<std::ptrdiff_t>(k) * kGroupLanes,
                kGroupLanes * sizeof(double));
  }
}

SkybodyLanes DualGroup::view() {
  const auto block = [this](const Block& b) { return value(b.offset); };
  SkybodyLanes v{};
  v.lanes = kGroupLanes;
  v.q = block(layout_.q);
  v.bodies = value(bodies_);
  v.u = block(layout_.u);
  v.rotor_speed = block(layout_.rotor_speed);
  v.rotor_command = block(layout_.rotor_command);
  v.params = block(layout_.params);
  v.sensors = block(layout_.sensors);
  v.action = block(layout_.action);
  v.command = block(layout_.command);
  const auto block_or_null = [&](const Block& b) { return b.size > 0 ? block(b) : nullptr; };
  v.contacts = block_or_null(layout_.contacts);
  v.contact_pairs = block_or_null(layout_.contact_pairs);
  v.joint_reactions = block_or_null(layout_.joint_reactions);
  v.scratch = scratch_.data();
  return v;
}

}  // namespace skybody
