// Physics of a lane group: environments side by side, one physics step at a time.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/physics/contact.h"
#include "core/physics/world.h"

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
};

/// Work space of one thread that steps groups of a world. Holds nothing between two calls.
using PhysicsScratch = AlignedArray<std::byte>;

struct PackWorld;

/// Physics steps of environments, failed ones included, by the dynamics that took them.
struct StepCounts {
  std::uint64_t tree = 0;
  std::uint64_t simbody = 0;
};

/// The physics of one group. Holds only what can be derived from World and the group's values (a
/// cache): results never depend on which states it saw before. Not thread-safe.
class GroupStepper {
 public:
  virtual ~GroupStepper() = default;

  /// Brings quaternions to norm 1 and makes `bodies`, and all else that follows from the values,
  /// current for these lanes after the values were changed from outside. Every lane is refreshed
  /// before it is first stepped.
  /// @param drawn  those of the lanes whose parameters may have been changed, too
  virtual void refresh(const GroupBlocks& group, std::uint32_t lanes, std::uint32_t drawn,
                       PhysicsScratch& scratch) = 0;

  /// Advances q, u, rotor speeds and bodies of these lanes by exactly dt, commands, wrenches and
  /// drives held.
  /// @returns the lanes that came through; the others, whose step gave a value that is not finite
  /// or
  ///          beyond 1e6 (free robots: rates of turn, and the magnitudes of all else added up), or
  ///          where the dynamics gave up, are as they were before the call
  virtual std::uint32_t advance(const GroupBlocks& group, std::uint32_t lanes,
                                PhysicsScratch& scratch) = 0;

  /// Generalised accelerations of one lane at the present state and t = 0 of the step, one per u.
  /// @throws Error if the parameters are not physical; std::runtime_error if the dynamics gives up
  virtual void accelerations(const GroupBlocks& group, int lane, double* udot) = 0;

  /// Appends the contacts of one lane's bodies with one another and with obstacles.
  /// @throws as accelerations
  virtual void add_contacts(const GroupBlocks& group, int lane, std::vector<Contact>& out) = 0;

  /// The lanes whose last advance went on Simbody, whether they came through or not.
  std::uint32_t on_simbody() const { return on_simbody_; }
  /// All steps since it was made. For looking at: nothing depends on them.
  const StepCounts& counts() const { return counts_; }

 protected:
  /// To be called in advance().
  /// @param lanes  that were to be advanced  @param on_simbody  those of them on Simbody
  void note_step(std::uint32_t lanes, std::uint32_t on_simbody) {
    on_simbody_ = on_simbody;
    const auto simbody = static_cast<std::uint64_t>(std::popcount(on_simbody));
    counts_.simbody += simbody;
    counts_.tree += static_cast<std::uint64_t>(std::popcount(lanes)) - simbody;
  }

 private:
  std::uint32_t on_simbody_ = 0;
  StepCounts counts_;
};

/// Makes steppers for the groups of a world, with what they share. Immutable, thread-safe.
class GroupPhysics {
 public:
  /// @param world  must outlive it
  /// @throws as make_stepper (stepper.h)
  explicit GroupPhysics(const World& world);
  ~GroupPhysics();

  /// Lanes in which the world is best stepped: kGroupLanes where that goes in packs, else 1.
  int preferred_lanes() const;

  /// Whether `bodies` is q, then u, value by value (one robot, a free body).
  bool bodies_are_coordinates() const { return bodies_are_coordinates_; }

  /// Work space for any group of the world.
  PhysicsScratch make_scratch() const;

  /// In packs where `lanes` is kGroupLanes and the world allows it, else lane after lane; the bits
  /// are the same.
  std::unique_ptr<GroupStepper> make_stepper(int lanes) const;

 private:
  const World& world_;
  bool bodies_are_coordinates_;
  std::unique_ptr<const PackWorld> packs_;  ///< null: lane after lane only
};

/// Lane after lane, over the dynamics and the integrator that the scenario asks for.
std::unique_ptr<GroupStepper> make_serial_group_stepper(const World& world, int lanes);

/// In packs of the widest instruction set at hand: groups of kGroupLanes on the tree dynamics;
/// lanes within reach (reach.h) go one by one on Simbody for that step.
std::unique_ptr<GroupStepper> make_pack_group_stepper(const PackWorld& world);

}  // namespace skybody
