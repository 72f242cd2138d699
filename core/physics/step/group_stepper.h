// Physics of a lane group: environments side by side, one physics step at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/physics/bodies/spatial_force.h"
#include "core/physics/contact/contact.h"
#include "core/physics/step/dynamics_choice.h"
#include "core/physics/world/world.h"

namespace skybody {

/// Where the values of a group lie: value k of lane l at k * lanes + l.
struct GroupBlocks {
  int lanes = 1;
  double* q = nullptr;
  double* u = nullptr;
  double* rotor_speed = nullptr;
  const double* rotor_command = nullptr;
  const double* wrench = nullptr;
  const double* drive = nullptr;
  const double* params = nullptr;
  /// 13 per body (BodyState): follows from q and u. Of one free body it is q and u themselves: then
  /// it may be the same memory.
  double* bodies = nullptr;
  const double* joint_command = nullptr;
  double* joint_state = nullptr;
  double* coupling_forces = nullptr;
  double* bristles = nullptr;
  const double* held[SKYBODY_HELD_COUNT] = {};  ///< core/base/held_inputs.h; null: not used
};

/// A block that steps read, and where it lies in state words. Those that effects hold come on top.
struct InputBlock {
  const double* GroupBlocks::*values;
  Block Layout::*place;
};
inline constexpr InputBlock kInputBlocks[] = {
    {&GroupBlocks::rotor_command, &Layout::rotor_command},
    {&GroupBlocks::wrench, &Layout::wrench},
    {&GroupBlocks::drive, &Layout::drive},
    {&GroupBlocks::params, &Layout::params},
    {&GroupBlocks::joint_command, &Layout::joint_command}};

/// A block that steps change.
struct StateBlock {
  double* GroupBlocks::*values;
  Block Layout::*place;
};
inline constexpr StateBlock kStateBlocks[] = {
    {&GroupBlocks::q, &Layout::q},
    {&GroupBlocks::u, &Layout::u},
    {&GroupBlocks::rotor_speed, &Layout::rotor_speed},
    {&GroupBlocks::joint_state, &Layout::joint_state},
    {&GroupBlocks::coupling_forces, &Layout::coupling_forces},
    {&GroupBlocks::bristles, &Layout::bristles}};
/// Those that a step changes before contact corrects it: the first of them.
inline constexpr std::span kSteppedBlocks = std::span(kStateBlocks).first<5>();

/// Work space of one thread that steps groups of a world. Holds nothing between two calls.
using PhysicsScratch = AlignedArray<std::byte>;

struct StepCall;
struct StepKernels;
struct StepPlan;

/// Physics steps of environments, failed ones included.
struct StepCounts {
  std::uint64_t all = 0;
  std::uint64_t near = 0;  ///< those of them in which something was near enough to touch
};

/// The physics of one group. Holds only what can be derived from World and the group's values (a
/// cache): results never depend on which states it saw before. Not thread-safe.
class GroupStepper {
 public:
  /// @param plan   must outlive it
  /// @param lanes  1, or kGroupLanes where kernels take the steps (StepPlan::has_kernels)
  GroupStepper(const StepPlan& plan, int lanes);
  ~GroupStepper();

  /// Brings quaternions to norm 1 and makes `bodies`, and all else that follows from the values,
  /// current for these lanes after the values were changed from outside. Every lane is refreshed
  /// before it is first stepped.
  /// @param drawn  those of the lanes whose parameters may have been changed, too
  void refresh(const GroupBlocks& group, std::uint32_t lanes, std::uint32_t drawn,
               PhysicsScratch& scratch);

  /// Advances q, u, rotor speeds, joint states and bodies of these lanes by exactly dt, commands,
  /// wrenches and drives held.
  /// @returns the lanes that came through; the others, whose step gave values that are not finite
  ///          or have diverged ("A fault" in docs/architecture.md), or where the dynamics gave up,
  ///          are as they were before the call
  std::uint32_t advance(const GroupBlocks& group, std::uint32_t lanes, PhysicsScratch& scratch);

  /// Generalised accelerations of one lane, which is refreshed, at the present state and t = 0 of
  /// the step, one per u.
  /// @throws Error if the parameters are not physical; std::runtime_error if the dynamics gives up
  void accelerations(const GroupBlocks& group, int lane, PhysicsScratch& scratch, double* udot);

  /// What joints exert on the bodies that they move, likewise.
  /// @param out  one per body: joint_reactions.h
  void joint_reactions(const GroupBlocks& group, int lane, PhysicsScratch& scratch,
                       SpatialForce<double>* out);
  /// The refreshed lanes where something touches, or is near enough to touch within a step.
  std::uint32_t may_touch(const GroupBlocks& group, std::uint32_t lanes, PhysicsScratch& scratch);
  /// Appends the contacts of one refreshed lane. @throws as accelerations
  void add_contacts(const GroupBlocks& group, int lane, PhysicsScratch& scratch,
                    std::vector<Contact>& out);

  /// The lanes in whose last advance something was near enough to touch.
  std::uint32_t near() const { return near_; }
  /// The lanes whose parameters no rigid body has, as of their last refresh(): their steps fail.
  std::uint32_t unphysical() const { return broken_; }
  /// All steps since it was made. For looking at: nothing depends on them.
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
  AlignedArray<double> spins_;    ///< per body: angular velocity (W), in lanes; unless the world
                                  ///< has free robots only
  AlignedArray<double> derived_;  ///< of all lanes; empty: none was ever drawn
  std::vector<std::uint32_t> near_pairs_;  ///< StepCall's
  AlignedArray<double> clearances_;  ///< StepCall's; empty with four shapes of obstacles or fewer
  AlignedArray<double> made_from_;   ///< parameters, of known lanes
  std::uint32_t known_ = 0;          ///< lanes whose numbers follow from `made_from_`
  std::uint32_t drawn_ = 0;          ///< lanes whose parameters are not the nominal ones
  std::uint32_t placed_ = 0;         ///< lanes of `derived_` that hold what is nominal
  std::uint32_t broken_ = 0;         ///< lanes with parameters that no body has
  std::uint32_t open_ = 0;           ///< lanes whose couplings cannot hold where their ends are
  std::uint32_t near_ = 0;
  StepCounts counts_;
  std::unique_ptr<ScalarFallback> fallback_;  ///< null: never needed so far
};

/// Makes steppers for the groups of a world, with what they share. Immutable, thread-safe.
class GroupPhysics {
 public:
  /// @param world  must outlive it
  /// @throws LocatedError as chosen_dynamics
  /// @throws Error (naming the body) if no rigid body can have the nominal mass properties
  explicit GroupPhysics(const World& world);
  GroupPhysics(const World& world, DynamicsBackend use);
  ~GroupPhysics();

  /// Lanes in which the world is best stepped: kGroupLanes where that goes in packs, else 1.
  int preferred_lanes() const;

  /// Whether `bodies` is q, then u, value by value (one robot, a free body).
  bool bodies_are_coordinates() const;

  /// Work space for any group of the world.
  PhysicsScratch make_scratch() const;

  /// @param lanes  1, or preferred_lanes(); the bits are the same
  std::unique_ptr<GroupStepper> make_stepper(int lanes) const;

 private:
  std::unique_ptr<const StepPlan> plan_;
};

/// Builds once whatever steppers of this world will ever build.
/// @throws as GroupPhysics, and Error (naming the body and the reason) where Simbody cannot build
/// it
void check_world(const World& world);

}  // namespace skybody
