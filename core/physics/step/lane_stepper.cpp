#include "core/physics/step/lane_stepper.h"

#include <functional>
#include <stdexcept>

#include "core/physics/step/contact_substeps.h"
#include "core/physics/step/equations_of_motion.h"

namespace skybody {
namespace {

/// Accelerations by Simbody, or by the tree's algorithms.
struct ChosenAccelerations {
  Dynamics* simbody;  ///< null: the tree's algorithms

  void operator()(const StepPlan& plan, const LaneValues<double>& derived,
                  const StepArrays<double>& a, const double* q, const double* u,
                  double* udot) const {
    if (simbody != nullptr) {
      simbody->accelerations(q, u, a.forces, a.joint_forces, udot);
    } else {
      TreeAccelerations()(plan, derived, a, q, u, udot);
    }
  }

  /// Replaces the accelerations by those with Simbody's own constraints, if Simbody is used.
  /// @param held  per coupling: whether it is an active equation
  void constrain(const StepArrays<double>& a, const double* q, const double* u, const bool* held,
                 double* udot) const {
    if (simbody == nullptr) return;
    simbody->hold(held);
    simbody->constrained_accelerations(q, u, a.forces, a.joint_forces, udot);
  }
  void project(const bool* held, double* q, double* u) const {
    if (simbody == nullptr) return;
    simbody->hold(held);
    simbody->project(q, u);
  }
};

/// Response to forces, by the tree's algorithms or Simbody.
struct ChosenResponse {
  Dynamics* simbody;

  void operator()(const StepPlan& plan, const CorrectionArrays<double>& a, bool is_again) const {
    if (simbody != nullptr) {
      simbody->accelerations(a.now.q, a.no_forces, a.contact.forces, a.no_forces, a.rates);
    } else {
      TreeResponse()(plan, a, is_again);
    }
  }
};

/// An algorithm on a single lane, with its arrays.
template <class Work, class Arrays>
class OneLane {
 public:
  OneLane(const StepCall& lane, AlignedArray<std::byte>& scratch, Dynamics* simbody)
      : arrays_(*lane.plan, scratch.data()),
        work_(lane, 0, LaneValues<double>(lane.group->params),
              LaneValues<double>(lane.derived != nullptr ? lane.derived
                                                         : lane.plan->nominal_derived.data()),
              arrays_, {simbody}) {}
  OneLane(const OneLane&) = delete;
  OneLane& operator=(const OneLane&) = delete;

  Work* operator->() { return &work_; }

 private:
  Arrays arrays_;
  Work work_;
};

/// The variant for any world. In worlds without rare cases it gives the bits of the usual variant.
using LaneEquations =
    OneLane<EquationsOfMotion<double, LaneValues<double>, TreeKind::kAny, ChosenAccelerations>,
            StepArrays<double>>;
using LaneContact =
    OneLane<ContactSubsteps<double, LaneValues<double>, ChosenResponse>, CorrectionArrays<double>>;

}  // namespace

LaneStepper::LaneStepper(const StepPlan& plan, std::unique_ptr<Dynamics> simbody)
    : plan_(plan),
      integrator_(make_integrator(plan.world)),
      simbody_(std::move(simbody)),
      scratch_(StepArrays<double>::bytes(plan)),
      contact_scratch_(CorrectionArrays<double>::bytes(plan)) {}

/// Simbody with the lane's mass properties, or null.
Dynamics* LaneStepper::dynamics(const StepCall& lane) {
  if (plan_.use != DynamicsBackend::kSimbody) return nullptr;
  if (simbody_ == nullptr) {
    simbody_ = make_simbody_dynamics(plan_.world, lane.group->params);
  } else {
    simbody_->set_params(lane.group->params);
  }
  return simbody_.get();
}

/// Dynamics throw on failure (a singular matrix, a NaN in a rotation, unphysical masses): the step
/// fails, but the program continues. Bugs (std::logic_error) and lack of memory are passed on.
bool LaneStepper::advance(const StepCall& lane) {
  try {
    LaneEquations mechanics(lane, scratch_, dynamics(lane));
    if (integrator_ != nullptr) {
      const auto advance = [&](auto& rates, double* q, double* u) {
        integrator_->advance(std::ref(rates), q, u);
      };
      return mechanics->advance_by(advance, true);
    }
    return mechanics->advance(true);
  } catch (const std::runtime_error&) {
    return false;
  }
}

bool LaneStepper::correct(const StepCall& lane) {
  try {
    return LaneContact(lane, contact_scratch_, dynamics(lane))->correct(true);
  } catch (const std::runtime_error&) {
    return false;
  }
}

void LaneStepper::accelerations(const StepCall& lane, double* udot) {
  LaneContact contact(lane, contact_scratch_, nullptr);
  contact->each_contact(NoContactList());
  LaneEquations(lane, scratch_, dynamics(lane))->accelerations(contact->forces(), udot);
}

void LaneStepper::joint_reactions(const StepCall& lane, SpatialForce<double>* out) {
  const World& world = plan_.world;
  udot_.resize(static_cast<std::size_t>(world.layout.u.size));
  accelerations_.resize(world.bodies.size());
  LaneContact contact(lane, contact_scratch_, nullptr);
  contact->each_contact(NoContactList());
  LaneEquations mechanics(lane, scratch_, dynamics(lane));
  mechanics->accelerations(contact->forces(), udot_.data());
  body_accelerations(plan_.multibody.bodies(), lane.group->q, lane.group->u, udot_.data(),
                     mechanics->motion(), accelerations_.data());
  skybody::joint_reactions(world, lane.group->params, mechanics->motion(), accelerations_.data(),
                           mechanics->forces(), out);
}

void LaneStepper::add_contacts(const StepCall& lane, std::vector<Contact>& out) {
  const ContactScene& scene = plan_.contact;
  LaneContact(lane, contact_scratch_, nullptr)
      ->each_contact([&](const CollisionPair& pair, const Vec3<double>& point,
                         const ContactKinematics<double>& touch, const Vec3<double>& force,
                         bool touches) {
        if (!touches) return;
        const auto body_of = [&](int i) { return scene.bodies[static_cast<std::size_t>(i)].body; };
        const int other =
            pair.other >= 0 ? body_of(pair.other)
            : !is_obstacle(pair.other)
                ? pair.other
                : kFirstObstacle -
                      scene.obstacle_owners[static_cast<std::size_t>(obstacle_of(pair.other))];
        out.push_back({body_of(pair.body), other, point, touch.normal, touch.depth, force});
      });
}

}  // namespace skybody
