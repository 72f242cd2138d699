// Joint reactions of lanes without contact.
#include "core/physics/step/equations_of_motion.h"
#include "core/physics/step/group_kernels.h"
#include "core/physics/step/reaction_arrays.h"

namespace skybody {
namespace {

struct JointReactions {
  template <int W>
  static SKYBODY_INLINE std::uint32_t run(const StepCall& call, std::uint32_t lanes) {
    using Real = RealOf<W>;
    ReactionArrays<Real> arrays(*call.plan, call.scratch);
    const auto bodies = static_cast<int>(call.plan->world.bodies.size());
    for (int i = 0; i < bodies; ++i) arrays.no_contact[i] = SpatialForce<Real>::zero();
    return for_packs<W, false>(
        call, lanes,
        [&](int first, std::uint32_t bits, const auto& params, const auto& derived)
            SKYBODY_INLINE_LAMBDA {
              using Values = std::decay_t<decltype(params)>;
              EquationsOfMotion<Real, Values, TreeKind::kUsual> mechanics(call, first, params,
                                                                          derived, arrays.step);
              Real* const udot = arrays.step.stages.rate.u;
              mechanics.accelerations(arrays.no_contact, udot);
              body_accelerations(call.plan->multibody.bodies(), 0, bodies, arrays.step.now.q,
                                 arrays.step.now.u, udot, mechanics.motion(), arrays.accelerations);
              joint_reactions_of(call.plan->world, params, mechanics.motion(), arrays.accelerations,
                                 mechanics.forces(), arrays.reactions);
              store(call.reactions, LaneSlice<Real>(first), mask_from_bits<Real>(bits),
                    arrays.reactions);
              return bits;
            });
  }

  template <class Real>
  static SKYBODY_INLINE void store(const ReactionRequest& request, const LaneSlice<Real>& lanes,
                                   const MaskOf<Real>& mask, const SpatialForce<Real>* reactions) {
    int next = 0;
    for (const int body : request.bodies) {
      const SpatialForce<Real>& r = reactions[body];
      const Real values[kReactionValues] = {r.force.x,  r.force.y,  r.force.z,
                                            r.moment.x, r.moment.y, r.moment.z};
      lanes.store(values, kReactionValues, mask, lanes.block(request.out, next));
      next += kReactionValues;
    }
  }
};

}  // namespace

StepKernel* reaction_kernel(int lanes, Isa isa) { return kernel_for<JointReactions>(lanes, isa); }

}  // namespace skybody
