#include "core/physics/simbody/dynamics.h"
#include "core/physics/step/group_stepper.h"
#include "core/physics/step/integrator.h"
#include "core/physics/step/step_plan.h"

namespace skybody {

GroupPhysics::GroupPhysics(const World& world) : GroupPhysics(world, chosen_dynamics(world)) {}

GroupPhysics::GroupPhysics(const World& world, DynamicsBackend use)
    : plan_(std::make_unique<const StepPlan>(world, use)) {}

GroupPhysics::~GroupPhysics() = default;

int GroupPhysics::preferred_lanes() const { return plan_->has_kernels() ? kGroupLanes : 1; }

bool GroupPhysics::bodies_are_coordinates() const {
  const StateLayout& layout = plan_->world.layout;
  return plan_->free_robots && plan_->world.bodies.size() == 1 &&
         layout.u.offset == layout.q.offset + layout.q.size;
}

PhysicsScratch GroupPhysics::make_scratch() const { return PhysicsScratch(plan_->scratch_bytes); }

std::unique_ptr<GroupStepper> GroupPhysics::make_stepper(int lanes) const {
  return std::make_unique<GroupStepper>(*plan_, lanes);
}

void check_world(const World& world) {
  const StepPlan plan(world, chosen_dynamics(world));
  make_integrator(world);
  if (plan.use == DynamicsBackend::kSimbody) check_simbody(world);
}

}  // namespace skybody
