// Physics of a lane group: environments side by side, one physics step at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/simd/aligned_array.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/contact/contact.h"
#include "core/physics/step/dynamics_choice.h"
#include "core/physics/world/world.h"

namespace skybody {

/// The memory of a group's values: value k of lane l is at k * lanes + l.
struct GroupBlocks {
  int lanes = 1;
  double* q = nullptr;
  double* u = nullptr;
  double* rotor_speed = nullptr;
  const double* rotor_command = nullptr;
  const double* wrench = nullptr;
  const double* drive = nullptr;
  const double* params = nullptr;
  /// 13 per body (BodyState): computed from q and u. For one free body the values are q and u
  /// themselves, and the memory may be the same.
  double* bodies = nullptr;
  const double* joint_command = nullptr;
  double* joint_state = nullptr;
  double* coupling_forces = nullptr;
  double* bristles = nullptr;
  const double* held[SKYBODY_HELD_COUNT] = {};  ///< core/base/held_inputs.h; null: not used
};

/// A block that steps read, and its block of state words. Held inputs are not in this list.
struct InputBlock {
  const double* GroupBlocks::*values;
  Block StateLayout::*place;
};
inline constexpr InputBlock kInputBlocks[] = {
    {&GroupBlocks::rotor_command, &StateLayout::rotor_command},
    {&GroupBlocks::wrench, &StateLayout::wrench},
    {&GroupBlocks::drive, &StateLayout::drive},
    {&GroupBlocks::params, &StateLayout::params},
    {&GroupBlocks::joint_command, &StateLayout::joint_command}};

/// A block that steps change.
struct StateBlock {
  double* GroupBlocks::*values;
  Block StateLayout::*place;
};
inline constexpr StateBlock kStateBlocks[] = {
    {&GroupBlocks::q, &StateLayout::q},
    {&GroupBlocks::u, &StateLayout::u},
    {&GroupBlocks::rotor_speed, &StateLayout::rotor_speed},
    {&GroupBlocks::joint_state, &StateLayout::joint_state},
    {&GroupBlocks::coupling_forces, &StateLayout::coupling_forces},
    {&GroupBlocks::bristles, &StateLayout::bristles}};
/// The blocks that a step changes before contact corrects it: the first of them.
inline constexpr std::span kSteppedBlocks = std::span(kStateBlocks).first<5>();

/// Work memory of one thread that steps groups of a world. Keeps nothing between two calls.
using PhysicsScratch = AlignedArray<std::byte>;

struct StepCall;
struct StepKernels;
struct StepPlan;

/// Number of physics steps of environments, including failed ones.
struct StepCounts {
  std::uint64_t all = 0;
  std::uint64_t near = 0;  ///< steps with a pair near enough to touch
};

/// The physics of one group. Keeps only values derived from World and the group's values (a cache):
/// results never depend on earlier states. Not thread-safe.
class GroupStepper {
 public:
  /// @param plan   must outlive it
  /// @param lanes  1, or kGroupLanes if kernels take the steps (StepPlan::has_kernels)
  GroupStepper(const StepPlan& plan, int lanes);
  ~GroupStepper();

  /// Updates these lanes after their values were changed from outside: normalises quaternions, and
  /// recomputes `bodies` and all other derived values. Every lane must be refreshed before its
  /// first step.
  /// @param drawn  the lanes of these whose parameters may have changed, too
  void refresh(const GroupBlocks& group, std::uint32_t lanes, std::uint32_t drawn,
               PhysicsScratch& scratch);

  /// Advances q, u, rotor speeds, joint states and bodies of these lanes by exactly dt, with
  /// constant commands, wrenches and drives.
  /// @returns the lanes that succeeded. The others keep their values from before the call: their
  ///          step gave values that are not finite or have diverged ("A fault" in
  ///          docs/architecture.md), or the dynamics failed
  std::uint32_t advance(const GroupBlocks& group, std::uint32_t lanes, PhysicsScratch& scratch);

  /// Generalised accelerations of one refreshed lane, at the current state and t = 0 of the step,
  /// one per u.
  /// @throws Error if the parameters are not physical; std::runtime_error if the dynamics fails
  void accelerations(const GroupBlocks& group, int lane, PhysicsScratch& scratch, double* udot);

  /// Forces and moments of joints on some bodies (joint_reactions.h), in refreshed lanes, likewise.
  /// Lanes whose dynamics fails keep their values.
  /// @param out  six values per body, in lanes: force, moment
  void joint_reactions(const GroupBlocks& group, std::uint32_t lanes, std::span<const int> bodies,
                       PhysicsScratch& scratch, double* out);
  /// The refreshed lanes with a pair that touches or may touch within a step.
  std::uint32_t may_touch(const GroupBlocks& group, std::uint32_t lanes, PhysicsScratch& scratch);
  /// Appends the contacts of one refreshed lane. @throws as accelerations
  void add_contacts(const GroupBlocks& group, int lane, PhysicsScratch& scratch,
                    std::vector<Contact>& out);

  /// The lanes with a pair near enough to touch in the last advance.
  std::uint32_t near() const { return near_; }
  /// The lanes with unphysical parameters, as of their last refresh(): their steps fail.
  std::uint32_t unphysical() const { return broken_; }
  /// All steps since construction. For statistics only.
  const StepCounts& counts() const { return counts_; }

 private:
  class ScalarFallback;
  StepCall call(const GroupBlocks& group, PhysicsScratch& scratch);
  std::uint32_t find_near(const StepCall& all, std::uint32_t lanes) const;
  std::uint32_t advance_alone(const StepCall& all, std::uint32_t lanes);
  std::uint32_t advance_fast(StepCall all, std::uint32_t lanes);
  bool fast_reads_derived() const;
  std::uint32_t correct(const StepCall& all, std::uint32_t lanes);
  double* remembered(const StepCall& all) const;
  void remember(const StepCall& all) const;
  void put_back(const StepCall& all, std::uint32_t lanes) const;
  bool derive_bodies(const GroupBlocks& group, int lane, PhysicsScratch& scratch);
  const double* make_bodies(const GroupBlocks& group, int lane, PhysicsScratch& scratch) const;
  void remember_params(const GroupBlocks& group, int lane);
  bool are_params(const double* mine, const double* others, int stride) const;
  void make_derived();
  void put_nominal(int lane);
  void forget_clearance(int lane);
  void put_derived(const double* derived, int first, int lane);
  ScalarFallback& alone();
  const StepKernels& kernels() const;

  const StepPlan& plan_;
  int lanes_;
  AlignedArray<double> spins_;  ///< per body: angular velocity (W), in lanes; not used if the world
                                ///< has free robots only
  AlignedArray<double> derived_;  ///< of all lanes; empty: parameters were never randomized
  std::vector<std::uint32_t> near_pairs_;  ///< StepCall's
  AlignedArray<double> clearances_;  ///< StepCall's; empty with four shapes of obstacles or fewer
  AlignedArray<double> made_from_;   ///< parameters, of known lanes
  std::uint32_t known_ = 0;          ///< lanes whose derived values belong to `made_from_`
  std::uint32_t drawn_ = 0;          ///< lanes whose parameters are not nominal
  std::uint32_t placed_ = 0;         ///< lanes of `derived_` that hold nominal values
  std::uint32_t broken_ = 0;         ///< lanes with unphysical parameters
  std::uint32_t open_ = 0;  ///< lanes whose couplings cannot hold at the positions of their ends
  std::uint32_t near_ = 0;
  StepCounts counts_;
  std::unique_ptr<ScalarFallback> fallback_;  ///< null: not needed so far
};

/// Makes steppers for the groups of a world, with their shared data. Immutable, thread-safe.
class GroupPhysics {
 public:
  /// @param world  must outlive it
  /// @throws LocatedError as chosen_dynamics
  /// @throws Error (naming the body) if the nominal mass properties are not physical
  explicit GroupPhysics(const World& world);
  GroupPhysics(const World& world, DynamicsBackend use);
  ~GroupPhysics();

  /// Best group size for the world: kGroupLanes if it can be stepped in packs, otherwise 1.
  int preferred_lanes() const;

  /// Whether `bodies` equals q, then u, value by value (one robot, a free body).
  bool bodies_are_coordinates() const;

  /// Work memory for any group of the world.
  PhysicsScratch make_scratch() const;

  /// @param lanes  1, or preferred_lanes(); the results have the same bits
  std::unique_ptr<GroupStepper> make_stepper(int lanes) const;

 private:
  std::unique_ptr<const StepPlan> plan_;
};

/// Builds once all objects that steppers of this world would build, as a check.
/// @throws as GroupPhysics, and Error (naming the body and the reason) if Simbody cannot build the
/// world
void check_world(const World& world);

}  // namespace skybody
