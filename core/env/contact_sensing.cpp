#include "core/env/contact_sensing.h"

#include <algorithm>

#include "core/base/simd/lane_mask.h"
#include "core/env/group_workspace.h"

namespace skybody {
namespace {

/// The body on which a contact's force is added up.
struct FeltBy {
  int body;
  double sign;  ///< -1: the contact contains the force on the other body
};

/// Adds a contact to a sum.
/// @param sum  SKYBODY_CONTACT_VALUES values of the lane
void add_contact(const Contact& contact, FeltBy by, const StateGroup& group, int lane,
                 double* sum) {
  const int lanes = group.lanes();
  const double* at = group.bodies() + 13 * by.body * lanes + lane;
  const Vec3<double> arm = contact.point - Vec3<double>{at[0], at[lanes], at[2 * lanes]};
  const Vec3<double> force = by.sign * contact.force, moment = cross(arm, force);
  for (const double value : {force.x, force.y, force.z, moment.x, moment.y, moment.z}) {
    *sum += value;
    sum += lanes;
  }
  *sum = 1.0;
}

/// The partner of a pair in the notation of Contact::other.
int partner_of(const ContactPair& pair) {
  if (pair.partner == SKYBODY_GROUND) return kGround;
  return pair.partner == SKYBODY_OBSTACLE ? kFirstObstacle - pair.other : pair.other;
}

/// Whether the dynamics succeeds. A lane in which it fails keeps its previous contact values: its
/// next step is a fault.
template <class Find>
bool comes_through(const Find& find) {
  try {
    find();
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

/// The lanes in which a plugin that `wants` something is called before the next physics step.
template <class Wants>
std::uint32_t lanes_of(const ScenarioModel& model, const StateGroup& group, std::uint32_t mask,
                       std::int64_t steps_left, const Wants& wants) {
  std::uint32_t lanes = 0;
  for (const auto& list : model.plugins) {
    for (const PluginInstance& p : list) {
      if (!wants(p)) continue;
      if (p.kind != SKYBODY_SENSOR) return mask;
      if (!is_left_out(p, steps_left)) lanes |= due(p, group, mask);
    }
  }
  return lanes;
}

void clear(double* values, int count, int lanes) {
  for (int k = 0; k < count; ++k) values[k * lanes] = 0.0;
}

}  // namespace

std::uint32_t ContactSensing::lanes_of_contacts(const StateGroup& group, std::uint32_t mask,
                                                std::int64_t steps_left) const {
  if (!model_.senses_contacts()) return 0;
  return lanes_of(model_, group, mask, steps_left, [](const PluginInstance& p) {
    return p.needs_contacts || !p.contact_pairs.empty();
  });
}

std::uint32_t ContactSensing::lanes_of_reactions(const StateGroup& group, std::uint32_t mask,
                                                 std::int64_t steps_left) const {
  if (model_.joint_reactions.empty()) return 0;
  return lanes_of(model_, group, mask, steps_left,
                  [](const PluginInstance& p) { return !p.joint_reactions.empty(); });
}

void ContactSensing::find(StateGroup& group, GroupWorkspace& work, int lane) {
  work.contacts.clear();
  group.add_contacts(lane, work.physics, work.contacts);
}

void ContactSensing::sense(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const {
  if (!model_.senses_contacts()) return;
  each_lane(mask, [&](int lane) {
    if (!comes_through([&] { find(group, work, lane); })) return;
    add_up_bodies(group, work.contacts, lane);
    add_up_pairs(group, work.contacts, lane);
  });
}

void ContactSensing::sense_after_step(StateGroup& group, GroupWorkspace& work,
                                      std::uint32_t mask) const {
  if (mask == 0) return;
  const std::uint32_t close = mask & (group.may_touch(mask, work.physics) | group.unphysical());
  set_free(group, mask & ~close);
  sense(group, work, close);
}

/// Writes that nothing touches.
void ContactSensing::set_free(StateGroup& group, std::uint32_t mask) const {
  const int lanes = group.lanes();
  for (const Block& block : {model_.layout().contacts, model_.layout().contact_pairs}) {
    double* const values = group.writable(block, mask);
    const std::uint32_t octets = whole_octets(mask);
    each_octet(octets, [&](int first) {
      for (int k = 0; k < block.size; ++k) std::fill_n(values + k * lanes + first, kOctet, 0.0);
    });
    each_lane(mask & ~octets, [&](int lane) { clear(values + lane, block.size, lanes); });
  }
}

void ContactSensing::add_up_bodies(StateGroup& group, const std::vector<Contact>& contacts,
                                   int lane) const {
  if (!model_.needs_contacts) return;
  const int lanes = group.lanes();
  double* const sums = group.writable(model_.layout().contacts, 1u << lane) + lane;
  clear(sums, model_.layout().contacts.size, lanes);
  const auto of = [&](int body) { return sums + SKYBODY_CONTACT_VALUES * body * lanes; };
  for (const Contact& c : contacts) {
    add_contact(c, {c.body, 1.0}, group, lane, of(c.body));
    if (c.other >= 0) add_contact(c, {c.other, -1.0}, group, lane, of(c.other));
  }
}

void ContactSensing::add_up_pairs(StateGroup& group, const std::vector<Contact>& contacts,
                                  int lane) const {
  if (model_.contact_pairs.empty()) return;
  const int lanes = group.lanes();
  double* sum = group.writable(model_.layout().contact_pairs, 1u << lane) + lane;
  clear(sum, model_.layout().contact_pairs.size, lanes);
  for (const ContactPair& pair : model_.contact_pairs) {
    const int partner = partner_of(pair);
    for (const Contact& c : contacts) {
      if (c.body == pair.body && c.other == partner) {
        add_contact(c, {pair.body, 1.0}, group, lane, sum);
      } else if (c.other == pair.body && c.body == partner) {
        add_contact(c, {pair.body, -1.0}, group, lane, sum);
      }
    }
    sum += SKYBODY_CONTACT_VALUES * lanes;
  }
}

void ContactSensing::sense_joint_reactions(StateGroup& group, GroupWorkspace& work,
                                           std::uint32_t mask) const {
  if (model_.joint_reactions.empty() || mask == 0) return;
  double* const out = group.writable(model_.layout().joint_reactions, mask);
  group.joint_reactions(mask, model_.joint_reactions, work.physics, out);
}

}  // namespace skybody
