// Work arrays of a contact correction, and the response of bodies to forces.
#pragma once

#include "core/physics/contact/contact_forces.h"
#include "core/physics/step/step_arrays.h"

namespace skybody {

/// Work arrays of a correction.
template <class Real>
struct CorrectionArrays {
  Coordinates<Real> before, now,
      end;  ///< at the substep's start; current; at the end of the step without contact
  Real *smooth, *no_forces;  ///< per u
  Real* bodies;              ///< kBodyConstantCount per body, of robots with near pairs
  Real* rates;               ///< per u: of a substep, first by contacts alone
  Real* mean_u;
  Vec3<Real>* coupling_forces;  ///< per coupling: mean over the step so far
  MaskOf<Real>* has_opened;     ///< per coupling: a substep left its gap open
  BodyKinematics<Real>*motion, *mean;
  BodyKinematics<Real>* at_rest;  ///< the same positions, at rest
  ContactWorkspace<Real> contact;
  typename MultibodyTree::template Work<Real> multibody;
  CouplingWorkspace<Real> couplings;
  HighSpinRobot<Real>* fast;  ///< per robot
  bool* is_robot_near;        ///< per robot: robots without near pairs are skipped

  SKYBODY_INLINE CorrectionArrays(const StepPlan& plan, std::byte* memory) {
    lay_out(plan, memory);
  }
  static std::size_t bytes(const StepPlan& plan) {
    CorrectionArrays sizes;
    return sizes.lay_out(plan, nullptr);
  }

 private:
  CorrectionArrays() = default;

  SKYBODY_INLINE std::size_t lay_out(const StepPlan& plan, std::byte* memory) {
    const StateLayout& layout = plan.world.layout;
    const std::size_t count = plan.world.bodies.size();
    const auto us = static_cast<std::size_t>(layout.u.size);
    const auto bristles = static_cast<std::size_t>(layout.bristles.size / 3);
    StepArena arena{memory};
    for (Coordinates<Real>* c : {&before, &now, &end}) c->take_from(arena, plan);
    for (Real** values : {&smooth, &rates, &mean_u, &no_forces}) arena.take(*values, us);
    arena.take(bodies, kBodyConstantCount * count);
    arena.take(motion, count);
    arena.take(mean, count);
    arena.take(at_rest, count);
    arena.take(contact.bounds, plan.contact.bodies.size());
    arena.take(contact.forces, count);
    arena.take(contact.kicks, count);
    arena.take(contact.sums, count);
    arena.take(contact.place_counts, count);
    arena.take(contact.bristles, bristles);
    arena.take(contact.bent, bristles);
    arena.take(multibody.body, count);
    arena.take(multibody.ball, count);
    arena.take(multibody.acceleration, count);
    couplings.take_from(arena, plan.couplings);
    arena.take(fast, layout.robots.size());
    arena.take(coupling_forces, plan.couplings.constraints.size());
    arena.take(has_opened, plan.couplings.constraints.size());
    arena.take(contact.is_bent, bristles);
    arena.take(contact.is_touched, count);
    arena.take(contact.is_body_near, plan.contact.bodies.size());
    arena.take(contact.near, static_cast<std::size_t>(plan.contact.most_near));
    const int places = plan.contact.most_near > 0 ? kKeptPlaces + plan.contact.most_places : 0;
    arena.take(contact.places, static_cast<std::size_t>(places));
    arena.take(contact.is_idle, bristles);
    arena.take(is_robot_near, layout.robots.size());
    return arena.used;
  }
};

/// Accelerations caused by forces on the bodies, by the tree's algorithms.
struct TreeResponse {
  /// @param is_again  only the forces have changed since the last call
  template <class Real>
  SKYBODY_INLINE void operator()(const StepPlan& plan, const CorrectionArrays<Real>& a,
                                 bool is_again) const {
    if (is_again) {
      return plan.multibody.accelerations_again(a.at_rest, a.bodies, a.contact.forces, a.no_forces,
                                                a.multibody, a.rates, a.is_robot_near);
    }
    plan.multibody.accelerations(a.now.q, a.no_forces, a.at_rest, a.bodies, a.contact.forces,
                                 a.no_forces, a.multibody, a.rates, a.is_robot_near);
  }
};

}  // namespace skybody
