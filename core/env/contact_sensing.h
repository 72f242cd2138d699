// Contact forces summed by body and by pair, and joint reactions, for plugins that request them.
// Computed lane by lane after each physics step and kept in state words until the next.
#pragma once

#include <cstdint>
#include <vector>

#include "core/env/scenario_model.h"
#include "core/physics/contact/contact.h"

namespace skybody {

/// Immutable; refers to the model, which must outlive it. Lanes must be up to date
/// (StateGroup::refresh). A lane in which the dynamics fails keeps its previous values: its next
/// step is a fault.
class ContactSensing {
 public:
  explicit ContactSensing(const ScenarioModel& model) : model_(model) {}

  /// The lanes of `mask` in which a plugin reads contacts before the next physics step: all, or if
  /// only sensors do, those in which one of them is called. @param steps_left  as
  /// SensingPhase::sense_due
  std::uint32_t lanes_of_contacts(const StateGroup& group, std::uint32_t mask,
                                  std::int64_t steps_left) const;
  /// The same for joint reactions.
  std::uint32_t lanes_of_reactions(const StateGroup& group, std::uint32_t mask,
                                   std::int64_t steps_left) const;

  void sense(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const;
  /// The same after a physics step: lanes with nothing near are found together and get zeros.
  void sense_after_step(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const;
  void sense_joint_reactions(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const;
  /// Computes the contacts of a lane, into the workspace.
  /// @throws std::runtime_error if the dynamics fails
  static void find(StateGroup& group, GroupWorkspace& work, int lane);

 private:
  void set_free(StateGroup& group, std::uint32_t mask) const;
  void add_up_bodies(StateGroup& group, const std::vector<Contact>& contacts, int lane) const;
  void add_up_pairs(StateGroup& group, const std::vector<Contact>& contacts, int lane) const;

  const ScenarioModel& model_;
};

}  // namespace skybody
