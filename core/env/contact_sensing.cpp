// Contact forces summed by body and by pair, and joint reactions, for plugins that request them.
// Computed lane by lane after each physics step and kept in state words until the next.
#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "core/env/compiled_scenario.h"
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

void clear(double* values, int count, int lanes) {
  for (int k = 0; k < count; ++k) values[k * lanes] = 0.0;
}

}  // namespace

std::vector<Contact> CompiledScenario::contacts(StateGroup& group, GroupWorkspace& work,
                                                int lane) const {
  const FpEnvironment guard;
  update(group, work, 1u << lane);
  find_contacts(group, work, lane);
  return work.contacts;
}

/// Computes the contacts of a lane that is up to date, into the workspace.
void CompiledScenario::find_contacts(StateGroup& group, GroupWorkspace& work, int lane) const {
  work.contacts.clear();
  group.add_contacts(lane, work.physics, work.contacts);
}

void CompiledScenario::sense_contacts(StateGroup& group, GroupWorkspace& work,
                                      std::uint32_t mask) const {
  if (!senses_contacts()) return;
  each_lane(mask, [&](int lane) {
    if (!comes_through([&] { find_contacts(group, work, lane); })) return;
    add_up_bodies(group, work.contacts, lane);
    add_up_pairs(group, work.contacts, lane);
  });
}

void CompiledScenario::add_up_bodies(StateGroup& group, const std::vector<Contact>& contacts,
                                     int lane) const {
  if (!needs_contacts_) return;
  const int lanes = group.lanes();
  double* const sums = group.writable(layout().contacts, 1u << lane) + lane;
  clear(sums, layout().contacts.size, lanes);
  const auto of = [&](int body) { return sums + SKYBODY_CONTACT_VALUES * body * lanes; };
  for (const Contact& c : contacts) {
    add_contact(c, {c.body, 1.0}, group, lane, of(c.body));
    if (c.other >= 0) add_contact(c, {c.other, -1.0}, group, lane, of(c.other));
  }
}

void CompiledScenario::add_up_pairs(StateGroup& group, const std::vector<Contact>& contacts,
                                    int lane) const {
  if (contact_pairs_.empty()) return;
  const int lanes = group.lanes();
  double* sum = group.writable(layout().contact_pairs, 1u << lane) + lane;
  clear(sum, layout().contact_pairs.size, lanes);
  for (const ContactPair& pair : contact_pairs_) {
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

void CompiledScenario::sense_joint_reactions(StateGroup& group, GroupWorkspace& work,
                                             std::uint32_t mask) const {
  if (joint_reactions_.empty()) return;
  const int lanes = group.lanes();
  each_lane(mask, [&](int lane) {
    const auto find = [&] {
      group.joint_reactions(lane, work.physics, work.joint_reactions.data());
    };
    if (!comes_through(find)) return;
    double* to = group.writable(layout().joint_reactions, 1u << lane) + lane;
    for (const int body : joint_reactions_) {
      const SpatialForce<double>& f = work.joint_reactions[static_cast<std::size_t>(body)];
      for (const double value :
           {f.force.x, f.force.y, f.force.z, f.moment.x, f.moment.y, f.moment.z}) {
        *to = value;
        to += lanes;
      }
    }
  });
}

}  // namespace skybody
