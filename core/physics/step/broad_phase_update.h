// Broad phase before every step of every environment: the pairs that may touch within the step.
// Loads only position, velocity and spin.
#pragma once

#include "core/physics/contact/broad_phase.h"
#include "core/physics/step/step_arrays.h"

namespace skybody {

/// Records in StepCall::near the lanes of each pair that may touch.
/// @tparam Values  access to values derived from parameters
/// @tparam Lanes   access to the lanes' values: a LaneSlice or LaneList
template <class Real, class Values, class Lanes = LaneSlice<Real>>
class BroadPhaseUpdate {
 public:
  /// @param lanes  the lanes of Real
  SKYBODY_INLINE BroadPhaseUpdate(const StepCall& call, const Lanes& lanes, const Values& derived)
      : call_(call),
        lanes_(lanes),
        arrays_(call.plan->contact, call.scratch),
        search_(call.plan->contact, derived + call.plan->derived.obstacles, arrays_.work) {}

  static std::size_t bytes(const StepPlan& plan) { return Arrays(plan.contact, nullptr).bytes; }

  /// @param is_unclear  written: lanes of `mask` that need measure() for their obstacles
  /// @returns lanes of `mask` with a near pair of another kind
  SKYBODY_INLINE MaskOf<Real> find(const MaskOf<Real>& mask, MaskOf<Real>& is_unclear) const {
    MaskOf<Real> is_near(false);
    is_unclear = search_.find_near(motion(), up(), mask, load_clearances(), take_down(is_near));
    return is_near;
  }

  /// Finds the obstacles that may be touched.
  /// @returns lanes of `mask` with a near obstacle
  SKYBODY_INLINE MaskOf<Real> measure(const MaskOf<Real>& mask) const {
    MaskOf<Real> is_near(false);
    Clearance<Real>* const known = load_clearances();
    search_.measure(motion(), mask, known, take_down(is_near));
    lanes_.store(reinterpret_cast<const Real*>(known), clearance_values(), mask, call_.clearances);
    return is_near;
  }

 private:
  struct Arrays {
    SKYBODY_INLINE Arrays(const ContactScene& scene, std::byte* memory) {
      StepArena arena{memory};
      arena.take(work.bounds, scene.bodies.size());
      arena.take(clearances, scene.bodies.size());
      bytes = arena.used;
    }
    ContactWorkspace<Real> work;
    Clearance<Real>* clearances;  ///< per contact body
    std::size_t bytes;
  };

  /// Motion of a contact body at the start of the step.
  SKYBODY_INLINE auto motion() const {
    return [this](const ContactBody& body) SKYBODY_INLINE_LAMBDA {
      return BodyTravel<Real>{vec3(body, 0), vec3(body, 7), vec3(body, 10)};
    };
  }
  SKYBODY_INLINE auto up() const {
    return [this](const ContactBody& body) SKYBODY_INLINE_LAMBDA {
      const Vec3<Real> axis = vec3(body, 4);
      return to_mat3(Quat<Real>{value(body, 3), axis.x, axis.y, axis.z}).row(2);
    };
  }
  /// Values of its motion (StepCall's bodies), starting with value k.
  SKYBODY_INLINE Vec3<Real> vec3(const ContactBody& body, int k) const {
    return {value(body, k), value(body, k + 1), value(body, k + 2)};
  }
  SKYBODY_INLINE Real value(const ContactBody& body, int k) const {
    Real out;
    lanes_.load(lanes_.block(call_.group->bodies, 13 * body.body + k), 1, &out);
    return out;
  }

  /// @param is_near  collects the lanes of all pairs
  SKYBODY_INLINE auto take_down(MaskOf<Real>& is_near) const {
    return [this, &is_near](int m, const MaskOf<Real>& here) SKYBODY_INLINE_LAMBDA {
      if (none(here)) return;
      is_near |= here;
      call_.near[m] |= lanes_.in_group(bits_from_mask(here));
    };
  }

  int clearance_values() const { return 4 * static_cast<int>(call_.plan->contact.bodies.size()); }
  SKYBODY_INLINE Clearance<Real>* load_clearances() const {
    if (call_.clearances == nullptr) return nullptr;
    lanes_.load(call_.clearances, clearance_values(), reinterpret_cast<Real*>(arrays_.clearances));
    return arrays_.clearances;
  }

  const StepCall& call_;
  Lanes lanes_;
  Arrays arrays_;
  BroadPhase<Real, Values> search_;
};

}  // namespace skybody
