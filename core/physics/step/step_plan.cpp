#include "core/physics/step/step_plan.h"

#include <algorithm>

#include "core/physics/step/broad_phase_update.h"
#include "core/physics/step/contact_substeps.h"
#include "core/physics/step/equations_of_motion.h"
#include "core/physics/step/free_robot_step.h"
#include "core/physics/step/reaction_arrays.h"

namespace skybody {

DerivedLayout::DerivedLayout(const World& world)
    : factors(kLagSize * static_cast<int>(world.rotors.size())),
      bodies(factors + kRotorFactorCount * static_cast<int>(world.rotors.size())),
      obstacles(bodies + kBodyConstantCount * static_cast<int>(world.bodies.size())),
      size(obstacles + kShapeConstantCount * count_obstacle_shapes(world.scenario)) {}

namespace {

/// The kernel for free robots without held inputs.
StepKernel* free_kernel(IntegratorChoice integrator, int lanes, Isa isa) {
  switch (integrator) {
    case IntegratorChoice::kRk4:
      return free_rk4_kernel(lanes, isa);
    case IntegratorChoice::kMidpoint:
      return free_midpoint_kernel(lanes, isa);
    default:  // semi-implicit Euler: other integrators have no kernels
      return free_euler_kernel(lanes, isa);
  }
}

StepKernels make_kernels(const StepPlan& plan, int lanes, Isa isa) {
  StepKernels kernels;
  kernels.refresh = refresh_kernel(lanes, isa);
  kernels.find_near = near_kernel(lanes, isa);
  kernels.project_constraints = gap_kernel(lanes, isa);
  kernels.correct = contact_kernel(lanes, isa);
  kernels.derive = derive_kernel(lanes, isa);
  if (!plan.has_kernels()) return kernels;
  const IntegratorChoice integrator = plan.world.scenario.stepping.integrator;
  if (!plan.free_robots) {
    kernels.advance = plan.has_rare_cases() ? tree_any_kernel(lanes, isa) : tree_kernel(lanes, isa);
  } else if (plan.held == HeldInputSet::kAir) {
    kernels.advance = free_air_kernel(lanes, isa);
  } else if (plan.has_held()) {
    kernels.advance = free_held_kernel(integrator, lanes, isa);
  } else {
    kernels.advance = free_kernel(integrator, lanes, isa);
  }
  if (plan.free_robots) {
    kernels.advance_fast = free_fast_kernel(integrator, lanes, isa);
  } else if (!plan.has_rare_cases() && integrator != IntegratorChoice::kRk4) {
    kernels.advance_fast = tree_any_kernel(lanes, isa);
  }
  const bool is_usual = !plan.has_rare_cases() && plan.drives.empty();
  if (!plan.free_robots && is_usual && plan.couplings.constraints.empty()) {
    kernels.react = reaction_kernel(lanes, isa);
  }
  return kernels;
}

}  // namespace

StepPlan::StepPlan(const World& w, DynamicsBackend u)
    : world(w),
      use(u),
      multibody(w),
      forces(w),
      contact(w),
      couplings(w),
      stops(w),
      fast_square(fast_spin_square(w.scenario.stepping.dt)),
      derived(w),
      nominal_params(w.layout.nominal_params()),
      nominal_derived(static_cast<std::size_t>(derived.size)) {
  const double* nominal = nominal_params.data();
  derive_rotors(w, derived, nominal,
                [&](int k, double value) { nominal_derived[static_cast<std::size_t>(k)] = value; });
  make_body_constants(w, nominal, nominal_derived.data() + derived.bodies);
  make_obstacle_constants(w, nominal, nominal_derived.data() + derived.obstacles);
  for (const double value : nominal_params) shared_params.emplace_back(value);
  for (const double value : nominal_derived) shared_derived.emplace_back(value);
  int value = 0;
  for (std::size_t r = 0; r < w.drives.size(); ++r) {
    if (w.drives[r] == DriveKind::kNone) continue;
    drives.push_back({w.drives[r], w.layout.robots[r].first_body, value});
    value += kDriveSize;
  }
  if (FreeRobots::is_possible(w)) free_robots.emplace(w);
  for (const WorldRotor& rotor : w.rotors) has_reversible_rotors |= rotor.model->is_reversible();
  held = held_input_set(w, free_robots && free_robots->robots[0].is_plain_quadrotor);
  const auto one_lane =
      static_cast<std::size_t>(w.layout.physics_params + derived.size) * sizeof(double);
  using Widest = Pack<kWidestPack>;
  const std::size_t free_robots_bytes =
      w.layout.robots.size() * sizeof(FreeMotion<Widest>) + w.rotors.size() * sizeof(Widest);
  kernel_bytes = std::max(
      {ReactionArrays<Widest>::bytes(*this), CorrectionArrays<Widest>::bytes(*this),
       BroadPhaseUpdate<Widest, SharedValues<Widest>>::bytes(*this), one_lane, free_robots_bytes});
  kernel_bytes = (kernel_bytes + sizeof(Widest) - 1) / sizeof(Widest) * sizeof(Widest);
  std::size_t changed = 0;
  for (const StateBlock& b : kSteppedBlocks) {
    changed += static_cast<std::size_t>((w.layout.*b.place).size);
  }
  scratch_bytes = kernel_bytes + changed * kGroupLanes * sizeof(double);
  const Isa isa = best_isa();
  kernels_of_all = make_kernels(*this, kGroupLanes, isa);
  kernels_of_one = make_kernels(*this, 1, isa);
}

}  // namespace skybody
