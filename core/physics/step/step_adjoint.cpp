#include "core/physics/step/step_adjoint.h"

#include "core/base/simd/lane_mask.h"
#include "core/base/system/error.h"
#include "core/physics/bodies/body_constants.h"
#include "core/physics/step/group_stepper.h"

namespace skybody {
StepAdjoint::StepAdjoint(const World& world)
    : plan_(world, chosen_dynamics(world)),
      has_closed_form_(has_free_adjoint(plan_)),
      kernel_(free_adjoint_kernel(best_isa())) {
  if (plan_.has_kernels()) return;
  throw Error(
      "derivatives of steps are known of the engine's own dynamics with fixed steps, and this "
      "world "
      "is stepped by Simbody or by an integrator that chooses its steps: take `dynamics: tree` and "
      "`integrator: midpoint`, semi_implicit_euler or rk4, or train with fast-ppo");
}

AlignedArray<double> StepAdjoint::make_derived() const {
  const World& world = plan_.world;
  return AlignedArray<double>(static_cast<std::size_t>(plan_.derived.size) * kGroupLanes +
                              static_cast<std::size_t>(world.layout.physics_params) +
                              kBodyConstantCount *
                                  world.bodies.size());  // the rest is work memory for one lane
}

void StepAdjoint::derive(const double* params, std::uint32_t lanes,
                         AlignedArray<double>& all) const {
  const int params_count = plan_.world.layout.physics_params;
  const int constants = kBodyConstantCount * static_cast<int>(plan_.world.bodies.size());
  double* const own = all.data() + static_cast<std::ptrdiff_t>(plan_.derived.size) * kGroupLanes;
  double* const bodies = own + params_count;
  each_lane(lanes, [&](int lane) {
    double* const derived = all.data() + lane;
    for (int k = 0; k < params_count; ++k) own[k] = params[k * kGroupLanes + lane];
    const double* const values = own;
    derive_rotors(plan_.world, plan_.derived, values,
                  [&](int k, double value) { derived[k * kGroupLanes] = value; });
    make_body_constants(plan_.world, values, bodies);
    for (int k = 0; k < constants; ++k) {
      derived[(plan_.derived.bodies + k) * kGroupLanes] = bodies[k];
    }
  });
}

void StepAdjoint::pull_back(const double* values, const double* params,
                            const AlignedArray<double>& derived, std::uint32_t lanes,
                            double* adjoints) const {
  if (lanes == 0) return;
  const StateLayout& layout = plan_.world.layout;
  auto* const run = const_cast<double*>(values);  // kernels do not write
  const auto place = [&](Block block) {
    return run + static_cast<std::ptrdiff_t>(block.offset - layout.q.offset) * kGroupLanes;
  };
  GroupBlocks group;
  group.lanes = kGroupLanes;
  for (const StateBlock& b : kStateBlocks) group.*b.values = place(layout.*b.place);
  for (const InputBlock& b : kInputBlocks) group.*b.values = place(layout.*b.place);
  group.params = params;
  group.bodies = group.q;  // of one free body
  const StepCall call{&plan_, &group, nullptr, const_cast<double*>(derived.data()), nullptr};
  kernel_(call, lanes, adjoints);
}

}  // namespace skybody
