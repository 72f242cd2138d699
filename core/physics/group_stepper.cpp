#include "core/physics/group_stepper.h"

#include "core/physics/free_robots.h"
#include "core/physics/lane_values.h"
#include "core/physics/pack_world.h"
#include "core/physics/stepper.h"

namespace skybody {

namespace {

bool is_one_free_body(const World& world) {
  const Layout& layout = world.layout;
  return world.bodies.size() == 1 && FreeRobots::is_possible(world) &&
         layout.u.offset == layout.q.offset + layout.q.size;
}

}  // namespace

GroupPhysics::GroupPhysics(const World& world)
    : world_(world), bodies_are_coordinates_(is_one_free_body(world)) {
  // An error-controlled integrator's steps depend on the state: lanes would part.
  if (chosen_dynamics(world) != DynamicsUse::kSimbody &&
      !is_error_controlled(world.scenario.stepping.integrator)) {
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
