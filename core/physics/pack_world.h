// What stepping a world in packs needs besides the values of a group: made once, shared by all
// groups of the world.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/physics/force_model.h"
#include "core/physics/free_robots.h"
#include "core/physics/reach.h"
#include "core/physics/step_rules.h"
#include "core/physics/tree_accelerations.h"

namespace skybody {

/// A driven base.
struct PackDrive {
  DriveKind kind = DriveKind::kNone;
  int body = 0;
  int value = 0;  ///< first of its values within the drive block
};

/// Numbers derived from the parameters of one environment: the rotors' lags (kLagSize each) and
/// factors (kRotorFactorCount each), then the bodies' constants (kBodyConstantCount each).
struct DerivedLayout {
  explicit DerivedLayout(const World& world);
  int lags = 0;
  int factors = 0;
  int bodies = 0;
  int size = 0;
};

/// @param params   the parameter block of one environment
/// @param derived  DerivedLayout::size values
/// @throws Error (naming the body) if no rigid body can have the mass properties
void derive(const World& world, const DerivedLayout& layout, const double* params, double* derived);

/// The rotors' part of it, the rest being the bodies'.
/// @param params  of one environment, or of as many as Real has lanes: a pointer, or a view
/// @param store   store(k, value) for every place k of the rotors
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

/// One call of a kernel on a group.
struct PackCall {
  const struct PackWorld* world;
  const struct GroupBlocks* group;
  double* spins;          ///< per body: angular velocity (W), in lanes
  const double* derived;  ///< DerivedLayout::size values in lanes; null: all lanes are nominal
  std::byte* scratch;     ///< PackWorld::scratch_bytes
};

/// One physics step; returns the lanes that came through, the others are as they were.
using PackAdvance = std::uint32_t(const PackCall& call, std::uint32_t lanes);

/// The kernels of one instruction set.
struct PackKernels {
  /// Bodies and spins of these lanes from q and u.
  void (*refresh)(const PackCall& call, std::uint32_t lanes);
  PackAdvance* advance;
  /// Those of the lanes where something is within reach of something else (Reach).
  std::uint32_t (*within_reach)(const PackCall& call, std::uint32_t lanes);
};

/// Those of the best instruction set at hand (best_isa).
PackKernels choose_pack_kernels(IntegratorChoice integrator);

/// Derives what belongs to the rotors of some lanes.
/// @param derived  DerivedLayout::size values in lanes
using PackDerive = void(const PackCall& call, std::uint32_t lanes, double* derived);
PackDerive* choose_derive_kernel();

/// That of the best instruction set for worlds of free robots.
PackAdvance* choose_free_kernel(IntegratorChoice integrator);
/// Bytes of PackCall::scratch that it takes.
std::size_t free_kernel_scratch(const FreeRobots& robots);

/// Immutable; refers to the world, which must outlive it.
struct PackWorld {
  /// @throws Error as derive(), for the nominal values
  explicit PackWorld(const World& world);

  const World& world;
  Forest forest;
  ForceModel forces;
  Reach reach;
  std::optional<FreeRobots> free_robots;  ///< where the world has no others: they go quicker
  std::vector<PackDrive> drives;
  DerivedLayout derived;
  PackDerive* derive_rotors = nullptr;
  int physics_params = 0;              ///< the first so many words of the parameter block
  std::vector<double> nominal_params;  ///< the whole block
  std::vector<double> nominal_derived;
  PackKernels kernels;
  std::size_t scratch_bytes = 0;  ///< enough for a step of the widest pack, and for derive()
};

}  // namespace skybody
