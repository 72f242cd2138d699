#include "core/physics/step/lane_stepper.h"

#include <functional>
#include <stdexcept>

#include "core/physics/step/mechanics.h"

namespace skybody {
namespace {

/// Accelerations by Simbody, or by the tree's algorithms.
struct ChosenAccelerations {
  Dynamics* simbody;  ///< null: the tree's

  void operator()(const StepPlan& plan, const LaneValues<double>& derived,
                  const StepArrays<double>& a, const double* q, const double* u,
                  double* udot) const {
    if (simbody != nullptr) {
      simbody->accelerations(q, u, a.forces, a.joint_forces, udot);
    } else {
      TreeAccelerations()(plan, derived, a, q, u, udot);
    }
  }
};

/// In the form for held inputs, whether there are any or not: with the same bits.
using LaneMechanics = Mechanics<double, LaneValues<double>, true, ChosenAccelerations>;

LaneMechanics mechanics_of(StepCall lane, AlignedArray<std::byte>& scratch, Dynamics* simbody) {
  const double* derived =
      lane.derived != nullptr ? lane.derived : lane.plan->nominal_derived.data();
  lane.scratch = scratch.data();
  return {lane, 0, LaneValues<double>(lane.group->params), LaneValues<double>(derived), {simbody}};
}

}  // namespace

LaneStepper::LaneStepper(const StepPlan& plan, std::unique_ptr<Dynamics> simbody)
    : plan_(plan),
      integrator_(make_integrator(plan.world)),
      simbody_(std::move(simbody)),
      scratch_(StepArrays<double>::bytes(plan)) {}

/// Simbody with the lane's mass properties, or null.
Dynamics* LaneStepper::dynamics(const StepCall& lane, bool on_simbody) {
  if (!on_simbody) return nullptr;
  if (simbody_ == nullptr) {
    simbody_ = make_simbody_dynamics(plan_.world, lane.group->params);
  } else {
    simbody_->set_params(lane.group->params);
  }
  return simbody_.get();
}

/// Dynamics throw where they give up (a singular matrix, a NaN in a rotation, masses that no body
/// has): a failed step, not the end of the program. Bugs (std::logic_error) and lack of memory are
/// no such thing and pass.
bool LaneStepper::advance(const StepCall& lane, bool on_simbody) {
  try {
    LaneMechanics mechanics = mechanics_of(lane, scratch_, dynamics(lane, on_simbody));
    if (integrator_ != nullptr) {
      const auto advance = [&](auto& rates, double* q, double* u) {
        integrator_->advance(std::ref(rates), q, u);
      };
      return mechanics.advance_by(advance, true);
    }
    return mechanics.advance(true);
  } catch (const std::runtime_error&) {
    return false;
  }
}

void LaneStepper::accelerations(const StepCall& lane, bool on_simbody, double* udot) {
  mechanics_of(lane, scratch_, dynamics(lane, on_simbody)).accelerations(udot);
}

void LaneStepper::joint_reactions(const StepCall& lane, bool on_simbody,
                                  SpatialForce<double>* out) {
  const World& world = plan_.world;
  udot_.resize(static_cast<std::size_t>(world.layout.u.size));
  accelerations_.resize(world.bodies.size());
  LaneMechanics mechanics = mechanics_of(lane, scratch_, dynamics(lane, on_simbody));
  mechanics.accelerations(udot_.data());
  contacts_.clear();
  if (on_simbody) add_contacts(lane, contacts_);  // the ground's are among the forces already
  const BodyKinematics<double>* motion = mechanics.motion();
  for (const Contact& c : contacts_) {
    mechanics.forces()[c.body].add_force_at(c.point - motion[c.body].position, c.force);
    if (c.other < 0) continue;
    mechanics.forces()[c.other].add_force_at(c.point - motion[c.other].position, -c.force);
  }
  body_accelerations(plan_.forest.bodies(), lane.group->q, lane.group->u, udot_.data(), motion,
                     accelerations_.data());
  skybody::joint_reactions(world, lane.group->params, motion, accelerations_.data(),
                           mechanics.forces(), out);
}

void LaneStepper::add_contacts(const StepCall& lane, std::vector<Contact>& out) {
  dynamics(lane, true)->add_contacts(lane.group->q, lane.group->u, out);
}

}  // namespace skybody
