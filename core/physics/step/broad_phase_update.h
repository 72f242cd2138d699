// Which pairs may touch within the step that begins: before every step of every environment, so
// that it loads position, velocity and spin alone.
#pragma once

#include "core/physics/contact/broad_phase.h"
#include "core/physics/step/step_arrays.h"

namespace skybody {

/// Takes down into StepCall::near the lanes of each pair that may touch.
/// @tparam Values  how what derives from parameters is read
/// @tparam Lanes   how the lanes' values are read: a LaneSlice or LaneList
template <class Real, class Values, class Lanes = LaneSlice<Real>>
class BroadPhaseUpdate {
 public:
  /// @param lanes  that Real holds
  SKYBODY_INLINE BroadPhaseUpdate(const StepCall& call, const Lanes& lanes, const Values& derived)
      : call_(call),
        lanes_(lanes),
        arrays_(call.plan->contact, call.scratch),
        search_(call.plan->contact, derived + call.plan->derived.obstacles, arrays_.work) {}

  static std::size_t bytes(const StepPlan& plan) { return Arrays(plan.contact, nullptr).bytes; }

  /// @param is_unclear  written: lanes of `mask` whose obstacles measure() is to look at
  /// @returns lanes of `mask` where something else is near
  SKYBODY_INLINE MaskOf<Real> find(const MaskOf<Real>& mask, MaskOf<Real>& is_unclear) const {
    MaskOf<Real> is_near(false);
    is_unclear = search_.find_near(motion(), up(), mask, load_clearances(), take_down(is_near));
    return is_near;
  }

  /// Finds the obstacles that may be touched.
  /// @returns lanes of `mask` where one is near
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

  /// Of a contact body, as the step begins.
  SKYBODY_INLINE auto motion() const {
    return [this](const ContactBody& body) SKYBODY_INLINE_LAMBDA {
      return BodyWay<Real>{vec3(body, 0), vec3(body, 7), vec3(body, 10)};
    };
  }
  SKYBODY_INLINE auto up() const {
    return [this](const ContactBody& body) SKYBODY_INLINE_LAMBDA {
      const Vec3<Real> axis = vec3(body, 4);
      return to_mat3(Quat<Real>{value(body, 3), axis.x, axis.y, axis.z}).row(2);
    };
  }
  /// Values of its motion (StepCall's bodies), from value k on.
  SKYBODY_INLINE Vec3<Real> vec3(const ContactBody& body, int k) const {
    return {value(body, k), value(body, k + 1), value(body, k + 2)};
  }
  SKYBODY_INLINE Real value(const ContactBody& body, int k) const {
    Real out;
    lanes_.load(lanes_.block(call_.group->bodies, 13 * body.body + k), 1, &out);
    return out;
  }

  /// @param is_near  gets the lanes of all pairs
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
