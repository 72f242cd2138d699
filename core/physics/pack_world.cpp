#include "core/physics/pack_world.h"

#include <algorithm>
#include <cstring>

#include "core/base/lanes.h"
#include "core/physics/lane_values.h"
#include "core/physics/pack_mechanics.h"

namespace skybody {

DerivedLayout::DerivedLayout(const World& world)
    : factors(kLagSize * static_cast<int>(world.rotors.size())),
      bodies(factors + kRotorFactorCount * static_cast<int>(world.rotors.size())),
      size(bodies + kBodyConstantCount * static_cast<int>(world.bodies.size())) {}

void derive(const World& world, const DerivedLayout& layout, const double* params,
            double* derived) {
  derive_rotors(world, layout, params, [&](int k, double value) { derived[k] = value; });
  make_body_constants(world, params, derived + layout.bodies);
}

PackWorld::PackWorld(const World& w)
    : world(w),
      forest(w),
      forces(w),
      reach(w),
      derived(w),
      derive_rotors(choose_derive_kernel()),
      kernels(choose_pack_kernels(w.scenario.stepping.integrator)) {
  for (const EnvParam& param : w.layout.param_info) nominal_params.push_back(param.nominal);
  nominal_derived.resize(static_cast<std::size_t>(derived.size));
  derive(w, derived, nominal_params.data(), nominal_derived.data());
  physics_params = w.layout.disturbance_params.back() + kDisturbanceParamCount;
  int value = 0;
  for (std::size_t r = 0; r < w.drives.size(); ++r) {
    if (w.drives[r] == DriveKind::kNone) continue;
    drives.push_back({w.drives[r], w.layout.robots[r].first_body, value});
    value += kDriveSize;
  }
  const auto one_lane = static_cast<std::size_t>(physics_params + derived.size) * sizeof(double);
  scratch_bytes = std::max(PackArrays<Pack<kWidestPack>>::bytes(w, reach), one_lane);
  if (!FreeRobots::is_possible(w)) return;
  free_robots.emplace(w);
  kernels.advance = choose_free_kernel(w.scenario.stepping.integrator);
  scratch_bytes = std::max(scratch_bytes, free_kernel_scratch(*free_robots));
}

}  // namespace skybody
