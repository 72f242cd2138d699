// A group in packs: all its lanes at once, on the tree dynamics. Lanes where something is within
// reach leave the packs for that step: the stepper that takes one environment, and decides by the
// same Reach, takes them to Simbody.
#include <cstring>

#include "core/base/error.h"
#include "core/base/octets.h"
#include "core/physics/group_stepper.h"
#include "core/physics/lane_values.h"
#include "core/physics/pack_world.h"

namespace skybody {
namespace {

class PackGroupStepper final : public GroupStepper {
 public:
  explicit PackGroupStepper(const PackWorld& world)
      : world_(world),
        spins_(world.free_robots ? 0 : 3 * world.world.bodies.size() * kGroupLanes) {}

  void refresh(const GroupBlocks& group, std::uint32_t lanes, std::uint32_t drawn,
               PhysicsScratch& scratch) override {
    std::uint32_t own = 0;
    each_lane(drawn, [&](int l) {
      if (derive_bodies(group, l, scratch)) own |= 1u << l;
    });
    if (own != 0) world_.derive_rotors(call(group, scratch), own, derived_.data());
    world_.kernels.refresh(call(group, scratch), lanes);
  }

  std::uint32_t advance(const GroupBlocks& group, std::uint32_t lanes,
                        PhysicsScratch& scratch) override {
    const PackCall packs = call(group, scratch);
    const std::uint32_t handed =
        world_.reach.is_possible() ? world_.kernels.within_reach(packs, lanes) : 0;
    const std::uint32_t in_packs = lanes & ~broken_ & ~handed;
    std::uint32_t through = in_packs == 0 ? 0 : world_.kernels.advance(packs, in_packs);
    if (handed != 0) through |= advance_one_by_one(group, handed, scratch);
    note_step(lanes, handed);
    return through;
  }

  void accelerations(const GroupBlocks& group, int lane, double* udot) override {
    one_by_one().accelerations(group, lane, udot);
  }

  void add_contacts(const GroupBlocks& group, int lane, std::vector<Contact>& out) override {
    one_by_one().add_contacts(group, lane, out);
  }

 private:
  PackCall call(const GroupBlocks& group, PhysicsScratch& scratch) {
    return {&world_, &group, spins_.data(), drawn_ == 0 ? nullptr : derived_.data(),
            scratch.data()};
  }

  /// The lanes' own values go in and out of the other stepper, which has not seen them since it was
  /// last asked; what only packs keep (spins) is made anew.
  std::uint32_t advance_one_by_one(const GroupBlocks& group, std::uint32_t lanes,
                                   PhysicsScratch& scratch) {
    one_by_one().refresh(group, lanes, lanes, scratch);
    const std::uint32_t through = one_by_one().advance(group, lanes, scratch);
    world_.kernels.refresh(call(group, scratch), lanes);
    return through;
  }

  /// What follows from a lane's parameters where they are not the nominal ones, but for rotors.
  /// @returns whether they are not, and bodies can have them
  bool derive_bodies(const GroupBlocks& group, int lane, PhysicsScratch& scratch) {
    const std::uint32_t bit = 1u << lane;
    broken_ &= ~bit;
    if (is_nominal(group, lane)) {
      drawn_ &= ~bit;
      if ((placed_ & bit) == 0 && derived_.size() > 0) put_nominal(lane);
      return false;
    }
    make_derived();
    drawn_ |= bit;
    placed_ &= ~bit;
    auto* params = reinterpret_cast<double*>(scratch.data());
    double* derived = params + world_.physics_params;
    for (int k = 0; k < world_.physics_params; ++k)
      params[k] = group.params[k * kGroupLanes + lane];
    try {
      make_body_constants(world_.world, params, derived + world_.derived.bodies);
    } catch (const std::runtime_error&) {  // no body has such masses: this lane's steps fail
      broken_ |= bit;
      return false;
    }
    put(derived, world_.derived.bodies, lane);
    return true;
  }

  bool is_nominal(const GroupBlocks& group, int lane) const {
    for (int k = 0; k < world_.physics_params; ++k) {
      const double* value = group.params + k * kGroupLanes + lane;
      if (std::memcmp(value, &world_.nominal_params[static_cast<std::size_t>(k)], sizeof(double)) !=
          0) {
        return false;
      }
    }
    return true;
  }

  /// Made where a lane is first drawn: most worlds never need it.
  void make_derived() {
    if (derived_.size() > 0) return;
    derived_ = AlignedArray<double>(static_cast<std::size_t>(world_.derived.size) * kGroupLanes);
    for (int l = 0; l < kGroupLanes; ++l) put_nominal(l);
  }

  void put_nominal(int lane) {
    put(world_.nominal_derived.data(), 0, lane);
    placed_ |= 1u << lane;
  }

  /// The values from place `first` on.
  void put(const double* derived, int first, int lane) {
    for (int k = first; k < world_.derived.size; ++k) {
      derived_[static_cast<std::size_t>(k * kGroupLanes + lane)] = derived[k];
    }
  }

  GroupStepper& one_by_one() {
    if (!one_by_one_) one_by_one_ = make_serial_group_stepper(world_.world, kGroupLanes);
    return *one_by_one_;
  }

  const PackWorld& world_;
  AlignedArray<double> spins_;                ///< per body: angular velocity (W), in lanes; unless
                                              ///< the world has free robots only
  AlignedArray<double> derived_;              ///< of all lanes; empty: none was ever drawn
  std::uint32_t drawn_ = 0;                   ///< lanes whose parameters are not the nominal ones
  std::uint32_t placed_ = 0;                  ///< lanes of `derived_` that hold what is nominal
  std::uint32_t broken_ = 0;                  ///< lanes with parameters that no body has
  std::unique_ptr<GroupStepper> one_by_one_;  ///< for lanes within reach, and direct control
};

}  // namespace

std::unique_ptr<GroupStepper> make_pack_group_stepper(const PackWorld& world) {
  return std::make_unique<PackGroupStepper>(world);
}

}  // namespace skybody
