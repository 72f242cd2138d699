#include "core/physics/step/step_adjoint.h"

#include "core/base/error.h"
#include "core/base/octets.h"
#include "core/physics/bodies/body_constants.h"
#include "core/physics/step/group_stepper.h"

namespace skybody {
namespace {

bool bodies_are_coordinates(const World& world) {
  const Layout& l = world.layout;
  return FreeRobots::is_possible(world) && world.bodies.size() == 1 &&
         l.u.offset == l.q.offset + l.q.size;
}

}  // namespace

StepRows::StepRows(const World& world)
    : words(world.layout.bodies_before.offset - world.layout.q.offset),
      bodies(bodies_are_coordinates(world) ? 0 : 13 * static_cast<int>(world.bodies.size())) {}

StepAdjoint::StepAdjoint(const World& world)
    : plan_(world, chosen_dynamics(world)), rows_(world), kernel_(free_adjoint_kernel(best_isa())) {
  if (has_free_adjoint(plan_)) return;
  throw Error(
      "derivatives of steps are known of worlds of one robot, a free body with rotors along its z "
      "axis at one height, with `integrator: midpoint` and no effects: take --algo fast-ppo here");
}

AlignedArray<double> StepAdjoint::make_derived() const {
  return AlignedArray<double>(static_cast<std::size_t>(plan_.derived.size) * kGroupLanes);
}

void StepAdjoint::derive(const double* params, std::uint32_t lanes,
                         AlignedArray<double>& all) const {
  std::vector<double> own(static_cast<std::size_t>(plan_.world.layout.physics_params));
  std::vector<double> bodies(kBodyConstantCount * plan_.world.bodies.size());
  each_lane(lanes, [&](int lane) {
    double* const derived = all.data() + lane;
    for (std::size_t k = 0; k < own.size(); ++k)
      own[k] = params[k * kGroupLanes + static_cast<std::size_t>(lane)];
    const double* const values = own.data();
    derive_rotors(plan_.world, plan_.derived, values,
                  [&](int k, double value) { derived[k * kGroupLanes] = value; });
    make_body_constants(plan_.world, values, bodies.data());
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      derived[(static_cast<std::size_t>(plan_.derived.bodies) + k) * kGroupLanes] = bodies[k];
    }
  });
}

void StepAdjoint::pull_back(const double* values, const double* params,
                            const AlignedArray<double>& derived, std::uint32_t lanes,
                            double* adjoints) const {
  if (lanes == 0) return;
  const Layout& layout = plan_.world.layout;
  auto* const run = const_cast<double*>(values);  // kernels do not write
  const auto place = [&](Block block) {
    return run + static_cast<std::ptrdiff_t>(block.offset - layout.q.offset) * kGroupLanes;
  };
  GroupBlocks group;
  group.lanes = kGroupLanes;
  for (const StateBlock& b : kStateBlocks) group.*b.values = place(layout.*b.place);
  for (const InputBlock& b : kInputBlocks) group.*b.values = place(layout.*b.place);
  group.params = params;
  group.bodies =
      rows_.bodies == 0 ? group.q : run + static_cast<std::ptrdiff_t>(rows_.words) * kGroupLanes;
  for (std::size_t i = 0; i < layout.held.size(); ++i) {
    if (layout.held[i].size > 0) group.held[i] = place(layout.held[i]);
  }
  const StepCall call{&plan_, &group, nullptr, const_cast<double*>(derived.data()), nullptr};
  kernel_(call, lanes, adjoints);
}

}  // namespace skybody
