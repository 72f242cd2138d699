#include "core/physics/group_stepper.h"

#include "core/physics/lane_values.h"
#include "core/physics/pack_world.h"
#include "core/physics/stepper.h"

namespace skybody {

GroupPhysics::GroupPhysics(const World& world) : world_(world) {
  if (chosen_dynamics(world) != DynamicsUse::kSimbody) {
    packs_ = std::make_unique<const PackWorld>(world);
  }
}

GroupPhysics::~GroupPhysics() = default;

int GroupPhysics::preferred_lanes() const { return packs_ ? kGroupLanes : 1; }

PhysicsScratch GroupPhysics::make_scratch() const {
  return PhysicsScratch(packs_ ? packs_->scratch_bytes : 0);
}

std::unique_ptr<GroupStepper> GroupPhysics::make_stepper(int lanes) const {
  if (packs_ && lanes == kGroupLanes) return make_pack_group_stepper(*packs_);
  return make_serial_group_stepper(world_, lanes);
}

}  // namespace skybody
