// The constant data of stepping a world: made once, shared by all groups of the world.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/base/simd/isa.h"
#include "core/physics/contact/contact_scene.h"
#include "core/physics/coupling/coupling_scene.h"
#include "core/physics/forces/force_model.h"
#include "core/physics/step/dynamics_choice.h"
#include "core/physics/step/free_robots.h"
#include "core/physics/step/held_input_set.h"
#include "core/physics/step/integration_rules.h"
#include "core/physics/step/joint_stops.h"
#include "core/physics/tree/multibody_tree.h"
#include "core/physics/world/lane_values.h"

namespace skybody {

/// A driven base.
struct DrivenBase {
  DriveKind kind = DriveKind::kNone;
  int body = 0;
  int value = 0;  ///< first of its values within the drive block
};

/// Layout of the values derived from the parameters of one environment: the rotors' lags
/// (kLagSize each) and factors (kRotorFactorCount each), then the constants of the bodies
/// (kBodyConstantCount each) and of the obstacles' shapes (kShapeConstantCount each).
struct DerivedLayout {
  explicit DerivedLayout(const World& world);
  int lags = 0;
  int factors = 0;
  int bodies = 0;
  int obstacles = 0;
  int size = 0;
};

/// Computes the derived values of the rotors; those of bodies and obstacles are computed elsewhere.
/// @param params  of one environment, or of the lanes of Real: a pointer, or a view
/// @param store   store(k, value): called for every index k of the rotors
template <class Values, class Store>
SKYBODY_INLINE void derive_rotors(const World& world, const DerivedLayout& layout,
                                  const Values& params, Store&& store) {
  using Real = std::decay_t<decltype(params[0])>;
  for (int r = 0; r < static_cast<int>(world.rotors.size()); ++r) {
    const auto rotor = static_cast<std::size_t>(r);
    const auto constants = params + world.layout.rotor_params[rotor];
    const RotorLag<Real> lag = make_rotor_lag(constants, world.scenario.stepping.dt);
    for (int k = 0; k < kLagSize; ++k) {
      store(layout.lags + kLagSize * r + k, reinterpret_cast<const Real*>(&lag)[k]);
    }
    Real factors[kRotorFactorCount];
    make_rotor_factors(constants, make_rotor_place(world, rotor), factors);
    for (int k = 0; k < kRotorFactorCount; ++k) {
      store(layout.factors + kRotorFactorCount * r + k, factors[k]);
    }
  }
}

struct StepPlan;
struct GroupBlocks;

/// Coordinates of a group at the start of a completed step.
struct StepStart {
  const double* q = nullptr;
  const double* u = nullptr;
};

/// Values of one joint reaction: force and moment on the body about its origin, W axes.
inline constexpr int kReactionValues = 6;

/// For `react`: bodies of which joint reactions are wanted.
struct ReactionRequest {
  std::span<const int> bodies;
  double* out = nullptr;  ///< kReactionValues per body, in lanes
};

/// One call of a kernel on a group.
struct StepCall {
  const StepPlan* plan;
  const GroupBlocks* group;
  double* spins;         ///< per body: angular velocity (W), in lanes; null: recomputed
  double* derived;       ///< DerivedLayout::size values in lanes; null: all lanes are nominal
  std::byte* scratch;    ///< StepPlan::scratch_bytes
  StepStart start = {};  ///< for `correct`
  /// For `find_near`: Clearance of each contact body, four values in lanes; null: not kept
  double* clearances = nullptr;
  /// Per CollisionPair of the contact scene: the lanes in which it is near. `find_near` adds lanes,
  /// `correct` reads them. Pairs that forces do not move are left out
  std::uint32_t* near = nullptr;
  ReactionRequest reactions = {};
};

/// One operation on the lanes in `lanes`. @returns the lanes in which it succeeded or is true
using StepKernel = std::uint32_t(const StepCall& call, std::uint32_t lanes);

/// The kernels for groups of one size.
struct StepKernels {
  /// Computes bodies and spins from q and u.
  StepKernel* refresh = nullptr;
  /// One physics step; returns the lanes that succeeded. The others are unchanged.
  StepKernel* advance = nullptr;
  /// The same for the lanes that `advance` leaves: for free robots, lanes with a fast robot; for
  /// trees, all lanes of a pack that contains such a lane. Null: it leaves none.
  StepKernel* advance_fast = nullptr;
  /// The lanes with a pair that may touch within the coming step.
  StepKernel* find_near = nullptr;
  /// Closes the gaps of couplings after a change of values from outside; returns the lanes in which
  /// this succeeded.
  StepKernel* project_constraints = nullptr;
  /// Contact, applied as a correction after the step (contact_substeps.h); returns the lanes that
  /// succeeded. The others keep the step without contact.
  StepKernel* correct = nullptr;
  /// Derives the values of the rotors, into the memory of StepCall::derived.
  StepKernel* derive = nullptr;
  /// Joint reactions of lanes without contact, at the current state. Null: each lane alone.
  StepKernel* react = nullptr;
};

/// Kernels of one kind: for groups of kGroupLanes lanes with an instruction set, or for one lane.
StepKernel* refresh_kernel(int lanes, Isa isa);
StepKernel* near_kernel(int lanes, Isa isa);
StepKernel* contact_kernel(int lanes, Isa isa);
StepKernel* gap_kernel(int lanes, Isa isa);
StepKernel* derive_kernel(int lanes, Isa isa);
StepKernel* reaction_kernel(int lanes, Isa isa);
StepKernel* tree_kernel(int lanes, Isa isa);
StepKernel* tree_any_kernel(int lanes, Isa isa);
StepKernel* free_midpoint_kernel(int lanes, Isa isa);
StepKernel* free_euler_kernel(int lanes, Isa isa);
StepKernel* free_rk4_kernel(int lanes, Isa isa);
StepKernel* free_air_kernel(int lanes, Isa isa);
StepKernel* free_held_kernel(IntegratorChoice integrator, int lanes, Isa isa);
/// @returns null for rk4
StepKernel* free_fast_kernel(IntegratorChoice integrator, int lanes, Isa isa);

/// Immutable; refers to the world, which must outlive it.
struct StepPlan {
  /// @throws Error (naming the body) if the nominal mass properties are not physical
  StepPlan(const World& world, DynamicsBackend use);

  /// Whether kernels take the steps. Steps of an error-controlled integrator depend on the state,
  /// so that lanes diverge in their control flow.
  bool has_kernels() const {
    return !is_error_controlled(world.scenario.stepping.integrator) &&
           use != DynamicsBackend::kSimbody;
  }
  bool has_held() const { return held != HeldInputSet::kNothing; }
  /// Whether trees use the kernel for any world: see TreeKind in equations_of_motion.h.
  bool has_rare_cases() const { return has_held() || stops.any() || has_reversible_rotors; }
  /// Whether lanes read their own parameters even if these are nominal: a second kernel would
  /// double the compile time.
  bool never_shares() const {
    return free_robots ? held == HeldInputSet::kAnything : has_rare_cases();
  }
  /// The kernels for groups of kGroupLanes lanes, or of one.
  const StepKernels& kernels(int lanes) const {
    return lanes == 1 ? kernels_of_one : kernels_of_all;
  }

  const World& world;
  DynamicsBackend use;
  MultibodyTree multibody;
  ForceModel forces;
  ContactScene contact;
  CouplingScene couplings;
  JointStops stops;
  std::optional<FreeRobots> free_robots;  ///< set if all robots are free bodies: a faster step
  std::vector<DrivenBase> drives;
  double fast_square;  ///< fast_spin_square()
  HeldInputSet held = HeldInputSet::kNothing;
  bool has_reversible_rotors = false;
  DerivedLayout derived;
  std::vector<double> nominal_params;  ///< the whole block
  std::vector<double> nominal_derived;
  std::vector<WideValue> shared_params, shared_derived;  ///< the same, in the form that packs read
  std::size_t kernel_bytes = 0;   ///< sufficient for a step of the widest pack, and for deriving
  std::size_t scratch_bytes = 0;  ///< kernel_bytes, and a copy of the values that a step changes
  StepKernels kernels_of_all, kernels_of_one;
};

}  // namespace skybody
