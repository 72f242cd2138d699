// One environment's physics on a LaneState of its own, for tests.
#pragma once

#include <memory>
#include <vector>

#include "core/physics/bodies/default_state.h"
#include "core/physics/step/group_stepper.h"

namespace skybody::test {

/// A group of one lane. A change of the state by a test takes effect in the next call.
class Stepper {
 public:
  Stepper(const World& world, DynamicsBackend use)
      : physics_(world, use),
        stepper_(physics_.make_stepper(1)),
        scratch_(physics_.make_scratch()) {}

  void update_bodies(LaneState& state) { stepper_->refresh(blocks(state), 1, 1, scratch_); }
  /// @returns false if the step failed
  bool advance(LaneState& state) {
    update_bodies(state);
    return stepper_->advance(blocks(state), 1, scratch_) != 0;
  }
  bool was_near() const { return stepper_->near() != 0; }
  void accelerations(LaneState& state, double* udot) {
    update_bodies(state);
    stepper_->accelerations(blocks(state), 0, scratch_, udot);
  }
  void add_contacts(LaneState& state, std::vector<Contact>& out) {
    update_bodies(state);
    stepper_->add_contacts(blocks(state), 0, scratch_, out);
  }

  static GroupBlocks blocks(LaneState& s) {
    GroupBlocks group;
    group.bodies = reinterpret_cast<double*>(s.bodies.data());
    for (const StateBlock& b : kStateBlocks) group.*b.values = values_of(s, b.place).data();
    for (const InputBlock& b : kInputBlocks) group.*b.values = values_of(s, b.place).data();
    for (std::size_t i = 0; i < s.held.size(); ++i) {
      if (!s.held[i].empty()) group.held[i] = s.held[i].data();
    }
    return group;
  }

 private:
  GroupPhysics physics_;
  std::unique_ptr<GroupStepper> stepper_;
  PhysicsScratch scratch_;
};

/// With the scenario's dynamics, the tree's algorithms alone, or Simbody.
inline std::unique_ptr<Stepper> make_stepper(const World& world) {
  return std::make_unique<Stepper>(world, chosen_dynamics(world));
}
inline std::unique_ptr<Stepper> make_tree_stepper(const World& world) {
  return std::make_unique<Stepper>(world, DynamicsBackend::kTree);
}
inline std::unique_ptr<Stepper> make_simbody_stepper(const World& world) {
  return std::make_unique<Stepper>(world, DynamicsBackend::kSimbody);
}

}  // namespace skybody::test
