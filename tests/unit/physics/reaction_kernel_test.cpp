// Joint reactions of the lanes of a group have the bits of environments one by one.
#include <gtest/gtest.h>

#include <numeric>

#include "core/physics/step/lane_stepper.h"
#include "core/physics/step/step_plan.h"
#include "tests/unit/physics/random_worlds.h"
#include "tests/unit/physics/two_ways.h"

namespace skybody::test {
namespace {

/// Joint reactions of one environment by the stepper of single lanes: force, moment per body.
class OneByOne {
 public:
  explicit OneByOne(const World& world)
      : plan_(world, DynamicsBackend::kTree),
        stepper_(plan_),
        near_(plan_.contact.pairs.size()),
        reactions_(world.bodies.size()) {}

  bool has_kernel() const { return plan_.kernels(kGroupLanes).react != nullptr; }

  std::vector<double> of(LaneState& state) {
    const GroupBlocks one = Stepper::blocks(state);
    StepCall call{&plan_, &one, nullptr, derive(state), nullptr};
    call.near = near_.data();
    stepper_.joint_reactions(call, reactions_.data());
    std::vector<double> values;
    for (const SpatialForce<double>& r : reactions_) {
      values.insert(values.end(),
                    {r.force.x, r.force.y, r.force.z, r.moment.x, r.moment.y, r.moment.z});
    }
    return values;
  }

 private:
  double* derive(const LaneState& state) {
    derived_.resize(static_cast<std::size_t>(plan_.derived.size));
    const double* params = state.params.data();
    derive_rotors(plan_.world, plan_.derived, params,
                  [&](int k, double x) { derived_[static_cast<std::size_t>(k)] = x; });
    make_body_constants(plan_.world, params, derived_.data() + plan_.derived.bodies);
    make_obstacle_constants(plan_.world, params, derived_.data() + plan_.derived.obstacles);
    return derived_.data();
  }

  StepPlan plan_;
  LaneStepper stepper_;
  std::vector<std::uint32_t> near_;
  std::vector<SpatialForce<double>> reactions_;
  std::vector<double> derived_;
};

TEST(ReactionKernel, LanesHaveTheBitsOfEnvironmentsOneByOne) {
  int kernels = 0;
  for (std::uint64_t k = 0; k < 30; ++k) {
    Random<double> random{RandomKey{2026, 11}, k, 0, derive_stream("reaction_kernel_test")};
    const World world =
        make_world(make_scenario(busy(random_tree(random), random), kFixedSteps[k % 3]));
    const GroupPhysics physics(world);
    PackGroup packs(world, physics);
    OneByOne alone(world);
    kernels += alone.has_kernel() ? 1 : 0;
    const auto stepper = make_tree_stepper(world);
    std::vector<LaneState> states;
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      states.push_back(random_lane(random, world, k % 2 == 0 && lane % 3 != 0));
      stepper->update_bodies(states.back());  // normalises quaternions
      packs.set(lane, states.back());
    }
    packs.refresh(kAllLanes);
    std::vector<int> bodies(world.bodies.size());
    std::iota(bodies.begin(), bodies.end(), 0);
    AlignedArray<double> out(PackGroup::size(kReactionValues * static_cast<int>(bodies.size())));
    packs.stepper->joint_reactions(packs.group, kAllLanes, bodies, packs.scratch, out.data());
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      const std::vector<double> single = alone.of(states[static_cast<std::size_t>(lane)]);
      expect_same_bits(out, lane, single.data(), "tree " + std::to_string(k));
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  EXPECT_GE(kernels, 5) << "the others have stops";
}

}  // namespace
}  // namespace skybody::test
