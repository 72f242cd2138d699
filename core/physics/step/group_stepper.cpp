// Steps of a group. Kernels take all lanes at once with the tree's algorithms. With Simbody, and
// with integrators that choose their own times, each lane is stepped alone (LaneStepper): it is
// copied to a group of one lane and back. If a pair may touch, contact corrects the step afterwards
// (contact_substeps.h).
#include "core/physics/step/group_stepper.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "core/base/simd/lane_mask.h"
#include "core/base/system/error.h"
#include "core/physics/step/lane_stepper.h"
#include "core/physics/step/step_plan.h"

namespace skybody {

/// Steps the lanes of a group one at a time.
class GroupStepper::ScalarFallback {
 public:
  ScalarFallback(const StepPlan& plan, int lanes)
      : plan_(plan), steppers_(static_cast<std::size_t>(lanes)), near_(plan.contact.pairs.size()) {
    const StateLayout& layout = plan.world.layout;
    int total = plan.derived.size + layout.q.size + layout.u.size;
    for (const StateBlock& b : kStateBlocks) total += (layout.*b.place).size;
    for (const InputBlock& b : kInputBlocks) total += (layout.*b.place).size;
    for (const Block& b : layout.held) total += b.size;
    values_.resize(static_cast<std::size_t>(total) + 13 * plan.world.bodies.size());
  }

  /// Allocates the memory of add_contacts() in advance.
  void prepare_questions(int lane) { any_stepper(lane); }

  bool advance(const StepCall& all, int lane) {
    if (!stepper(lane).advance(take(all, lane))) return false;
    give(all, lane);
    return true;
  }
  bool correct(const StepCall& all, int lane) {
    if (!stepper(lane).correct(take(all, lane))) return false;
    give(all, lane);
    return true;
  }
  void accelerations(const StepCall& all, int lane, double* udot) {
    stepper(lane).accelerations(take(all, lane), udot);
  }
  void joint_reactions(const StepCall& all, int lane) {
    reactions_.resize(plan_.world.bodies.size());
    stepper(lane).joint_reactions(take(all, lane), reactions_.data());
    double* to = all.reactions.out + lane;
    for (const int body : all.reactions.bodies) {
      const SpatialForce<double>& r = reactions_[static_cast<std::size_t>(body)];
      for (const double value :
           {r.force.x, r.force.y, r.force.z, r.moment.x, r.moment.y, r.moment.z}) {
        *to = value;
        to += all.group->lanes;
      }
    }
  }
  void add_contacts(const StepCall& all, int lane, std::vector<Contact>& out) {
    any_stepper(lane).add_contacts(take(all, lane), out);
  }

 private:
  LaneStepper& stepper(int lane) {
    auto& stepper = steppers_[static_cast<std::size_t>(lane)];
    if (stepper == nullptr) stepper = std::make_unique<LaneStepper>(plan_);
    return *stepper;
  }

  /// Any existing stepper, for queries that do not need the lane's own Simbody system. Resets of
  /// whole batches use such queries, and a stepper for each lane needs memory.
  LaneStepper& any_stepper(int lane) {
    for (auto& stepper : steppers_) {
      if (stepper != nullptr) return *stepper;
    }
    return stepper(lane);
  }

  /// Copies a lane to a group of its own; without bodies.
  StepCall take(const StepCall& all, int lane) {
    const GroupBlocks& group = *all.group;
    const StateLayout& layout = plan_.world.layout;
    double* next = values_.data();
    const auto copy = [&](const double* from, int count) {
      double* to = next;
      for (int k = 0; k < count; ++k) *next++ = from[k * group.lanes + lane];
      return to;
    };
    for (const StateBlock& b : kStateBlocks) {
      one_.*b.values = copy(group.*b.values, (layout.*b.place).size);
    }
    for (const InputBlock& b : kInputBlocks) {
      one_.*b.values = copy(group.*b.values, (layout.*b.place).size);
    }
    for (std::size_t i = 0; i < layout.held.size(); ++i) {
      if (group.held[i] != nullptr) one_.held[i] = copy(group.held[i], layout.held[i].size);
    }
    StepCall call{&plan_, &one_, nullptr, nullptr, nullptr};
    if (all.derived != nullptr) call.derived = copy(all.derived, plan_.derived.size);
    if (all.start.q != nullptr) {
      call.start = {copy(all.start.q, layout.q.size), copy(all.start.u, layout.u.size)};
    }
    one_.bodies = next;
    call.near = near_.data();
    for (std::size_t m = 0; m < near_.size(); ++m) near_[m] = all.near[m] >> lane & 1u;
    return call;
  }
  void give(const StepCall& all, int lane) const {
    for (const StateBlock& b : kStateBlocks) {
      const double* from = one_.*b.values;
      double* to = all.group->*b.values + lane;
      const int count = (plan_.world.layout.*b.place).size;
      for (int k = 0; k < count; ++k, to += all.group->lanes) *to = from[k];
    }
  }

  const StepPlan& plan_;
  std::vector<std::unique_ptr<LaneStepper>> steppers_;
  std::vector<double> values_;  ///< memory of the blocks of `one_`
  std::vector<std::uint32_t> near_;
  std::vector<SpatialForce<double>> reactions_;  ///< of one lane; empty before the first call
  GroupBlocks one_;
};

GroupStepper::GroupStepper(const StepPlan& plan, int lanes)
    : plan_(plan),
      lanes_(lanes),
      spins_(plan.free_robots ? 0 : 3 * plan.world.bodies.size() * static_cast<std::size_t>(lanes)),
      near_pairs_(plan.contact.pairs.size()) {
  SKYBODY_DEMAND(lanes == 1 || (lanes == kGroupLanes && plan.has_kernels()),
                 "a group has 1 or 32 lanes");
  if (plan.never_shares() || fast_reads_derived()) make_derived();
  constexpr std::size_t kFewObstacles = 4;
  if (plan.contact.obstacles.size() <= kFewObstacles) return;
  clearances_ =
      AlignedArray<double>(4 * plan.contact.bodies.size() * static_cast<std::size_t>(lanes));
  for (int l = 0; l < lanes; ++l) forget_clearance(l);
}

GroupStepper::~GroupStepper() = default;

StepCall GroupStepper::call(const GroupBlocks& group, PhysicsScratch& scratch) {
  const bool is_shared = drawn_ == 0 && !plan_.never_shares();
  StepCall all{&plan_, &group, spins_.data(), is_shared ? nullptr : derived_.data(),
               scratch.data()};
  if (clearances_.size() > 0) all.clearances = clearances_.data();
  all.near = near_pairs_.data();
  return all;
}

void GroupStepper::refresh(const GroupBlocks& group, std::uint32_t lanes, std::uint32_t drawn,
                           PhysicsScratch& scratch) {
  std::uint32_t own = 0;
  each_lane(drawn, [&](int l) {
    if (derive_bodies(group, l, scratch)) own |= 1u << l;
    if (clearances_.size() > 0) forget_clearance(l);
  });
  const StepCall all = call(group, scratch);
  if (own != 0) kernels().derive(all, own);
  each_lane(own, [&](int l) { remember_params(group, l); });
  kernels().refresh(all, lanes);
  if (plan_.couplings.row_owners.empty()) return;
  const std::uint32_t able = lanes & ~broken_;
  open_ = (open_ & ~lanes) | (able & ~kernels().project_constraints(all, able));
}

std::uint32_t GroupStepper::advance(const GroupBlocks& group, std::uint32_t lanes,
                                    PhysicsScratch& scratch) {
  const StepCall all = call(group, scratch);
  const std::uint32_t able = lanes & ~(broken_ | open_);
  near_ = find_near(all, able);
  if (near_ != 0) remember(all);
  std::uint32_t through = 0;
  if (able != 0)
    through = plan_.has_kernels() ? kernels().advance(all, able) : advance_alone(all, able);
  const std::uint32_t left = able & ~through;
  if (left != 0 && kernels().advance_fast != nullptr) through |= advance_fast(all, left);
  if (near_ != 0) through &= ~(near_ & ~correct(all, near_ & through));
  counts_.all += static_cast<std::uint64_t>(std::popcount(lanes));
  counts_.near += static_cast<std::uint64_t>(std::popcount(near_));
  return through;
}

std::uint32_t GroupStepper::advance_fast(StepCall all, std::uint32_t lanes) {
  if (fast_reads_derived()) all.derived = derived_.data();
  return kernels().advance_fast(all, lanes);
}

/// Whether the kernel for fast lanes reads each lane's own parameters, nominal or not.
bool GroupStepper::fast_reads_derived() const {
  return !plan_.free_robots && kernels().advance_fast != nullptr;
}

/// Steps lanes one at a time. Refreshes the values that only kernels keep (bodies, spins).
std::uint32_t GroupStepper::advance_alone(const StepCall& all, std::uint32_t lanes) {
  std::uint32_t through = 0;
  each_lane(lanes, [&](int l) {
    if (alone().advance(all, l)) through |= 1u << l;
  });
  kernels().refresh(all, through);
  return through;
}

/// The lanes with a pair that may touch within the coming step.
std::uint32_t GroupStepper::find_near(const StepCall& all, std::uint32_t lanes) const {
  if (plan_.contact.pairs.empty() || lanes == 0) return 0;
  std::fill_n(all.near, plan_.contact.pairs.size(), 0u);
  return kernels().find_near(all, lanes);
}

/// Contact in lanes whose step has been taken. @returns the lanes that succeeded; the others return
/// to the state before the step
std::uint32_t GroupStepper::correct(const StepCall& taken, std::uint32_t lanes) {
  if (lanes == 0) return 0;
  StepCall all = taken;
  const double* before = remembered(all);
  all.start = {before, before + plan_.world.layout.q.size * lanes_};  // in the order of
                                                                      // kSteppedBlocks
  std::uint32_t through = 0;
  if (plan_.has_kernels()) {
    through = kernels().correct(all, lanes);
  } else {
    each_lane(lanes, [&](int l) {
      if (alone().correct(all, l)) through |= 1u << l;
    });
    kernels().refresh(all, through);
  }
  put_back(all, lanes & ~through);
  return through;
}

/// Copy of the values that a step changes, in scratch memory behind that of the kernels.
double* GroupStepper::remembered(const StepCall& all) const {
  return reinterpret_cast<double*>(all.scratch + plan_.kernel_bytes);
}

void GroupStepper::remember(const StepCall& all) const {
  double* to = remembered(all);
  for (const StateBlock& b : kSteppedBlocks) {
    const auto count = static_cast<std::size_t>((plan_.world.layout.*b.place).size * lanes_);
    if (count > 0) std::memcpy(to, all.group->*b.values, count * sizeof(double));
    to += count;
  }
}

void GroupStepper::put_back(const StepCall& all, std::uint32_t lanes) const {
  if (lanes == 0) return;
  each_lane(lanes, [&](int l) {
    const double* from = remembered(all) + l;
    for (const StateBlock& b : kSteppedBlocks) {
      double* to = all.group->*b.values + l;
      for (int k = 0; k < (plan_.world.layout.*b.place).size; ++k) {
        *to = *from;
        to += lanes_;
        from += lanes_;
      }
    }
  });
  kernels().refresh(all, lanes);
}

void GroupStepper::accelerations(const GroupBlocks& group, int lane, PhysicsScratch& scratch,
                                 double* udot) {
  if (((broken_ >> lane) & 1u) != 0) make_bodies(group, lane, scratch);  // throws
  alone().accelerations(call(group, scratch), lane, udot);
}

void GroupStepper::joint_reactions(const GroupBlocks& group, std::uint32_t lanes,
                                   std::span<const int> bodies, PhysicsScratch& scratch,
                                   double* out) {
  StepCall all = call(group, scratch);
  all.reactions = {bodies, out};
  std::uint32_t left = lanes & ~broken_;
  if (kernels().react != nullptr && !plan_.contact.has_idle) {
    const std::uint32_t near = find_near(all, left);
    if (const std::uint32_t apart = left & ~near; apart != 0) kernels().react(all, apart);
    left = near;
  }
  each_lane(left, [&](int l) {
    try {
      alone().joint_reactions(all, l);
    } catch (const std::runtime_error&) {  // the lane's next step is a fault
    }
  });
}

/// Lanes with unphysical parameters fail in their first step: they have no contacts.
std::uint32_t GroupStepper::may_touch(const GroupBlocks& group, std::uint32_t lanes,
                                      PhysicsScratch& scratch) {
  if (plan_.contact.has_idle) return lanes & ~broken_;
  return find_near(call(group, scratch), lanes & ~broken_);
}

void GroupStepper::add_contacts(const GroupBlocks& group, int lane, PhysicsScratch& scratch,
                                std::vector<Contact>& out) {
  const StepCall all = call(group, scratch);
  alone().prepare_questions(lane);  // at the first call, near or not: later calls do not allocate
  const bool may_touch = plan_.contact.has_idle || find_near(all, 1u << lane) != 0;
  if (may_touch) alone().add_contacts(all, lane, out);
}

/// Recomputes a lane's body constants if its parameters have changed and are not nominal.
/// @returns true if those of the rotors must be recomputed, too
bool GroupStepper::derive_bodies(const GroupBlocks& group, int lane, PhysicsScratch& scratch) {
  const std::uint32_t bit = 1u << lane;
  const double* mine = group.params + lane;
  if ((known_ & bit) != 0 && are_params(mine, made_from_.data() + lane, lanes_)) return false;
  known_ &= ~bit;
  broken_ &= ~bit;
  if (are_params(mine, plan_.nominal_params.data(), 1)) {
    drawn_ &= ~bit;
    if ((placed_ & bit) == 0 && derived_.size() > 0) put_nominal(lane);
    return false;
  }
  make_derived();
  drawn_ |= bit;
  placed_ &= ~bit;
  try {
    put_derived(make_bodies(group, lane, scratch), plan_.derived.bodies, lane);
  } catch (const std::runtime_error&) {  // unphysical masses: this lane's steps fail
    broken_ |= bit;
    return false;
  }
  return true;
}

/// @returns DerivedLayout::size values in scratch; only those of bodies and obstacles are set
/// @throws Error (naming the body) if the lane's mass properties are not physical
const double* GroupStepper::make_bodies(const GroupBlocks& group, int lane,
                                        PhysicsScratch& scratch) const {
  auto* params = reinterpret_cast<double*>(scratch.data());
  double* derived = params + plan_.world.layout.physics_params;
  for (int k = 0; k < plan_.world.layout.physics_params; ++k)
    params[k] = group.params[k * lanes_ + lane];
  make_body_constants(plan_.world, params, derived + plan_.derived.bodies);
  make_obstacle_constants(plan_.world, params, derived + plan_.derived.obstacles);
  return derived;
}

/// Records that the lane's derived values belong to its current parameters.
void GroupStepper::remember_params(const GroupBlocks& group, int lane) {
  known_ |= 1u << lane;
  for (int k = 0; k < plan_.world.layout.physics_params; ++k) {
    made_from_[static_cast<std::size_t>(k * lanes_ + lane)] = group.params[k * lanes_ + lane];
  }
}

/// Whether the parameters of the physics have the same bits.
/// @param mine    of one lane of a group
/// @param stride  of `others`
bool GroupStepper::are_params(const double* mine, const double* others, int stride) const {
  for (int k = 0; k < plan_.world.layout.physics_params; ++k, mine += lanes_, others += stride) {
    if (std::memcmp(mine, others, sizeof(double)) != 0) return false;
  }
  return true;
}

/// Allocated when parameters of a lane are first randomized: most worlds never need it.
void GroupStepper::make_derived() {
  if (derived_.size() > 0) return;
  derived_ = AlignedArray<double>(static_cast<std::size_t>(plan_.derived.size * lanes_));
  made_from_ =
      AlignedArray<double>(static_cast<std::size_t>(plan_.world.layout.physics_params * lanes_));
  for (int l = 0; l < lanes_; ++l) put_nominal(l);
}

void GroupStepper::put_nominal(int lane) {
  put_derived(plan_.nominal_derived.data(), 0, lane);
  placed_ |= 1u << lane;
}

/// Stores the values from index `first` on.
void GroupStepper::put_derived(const double* derived, int first, int lane) {
  for (int k = first; k < plan_.derived.size; ++k) {
    derived_[static_cast<std::size_t>(k * lanes_ + lane)] = derived[k];
  }
}

/// Invalidates clearances: obstacles may have moved.
void GroupStepper::forget_clearance(int lane) {
  for (std::size_t i = 0; i < plan_.contact.bodies.size(); ++i) {
    clearances_[(4 * i + 3) * static_cast<std::size_t>(lanes_) + static_cast<std::size_t>(lane)] =
        -1.0;
  }
}

GroupStepper::ScalarFallback& GroupStepper::alone() {
  if (!fallback_) fallback_ = std::make_unique<ScalarFallback>(plan_, lanes_);
  return *fallback_;
}

const StepKernels& GroupStepper::kernels() const { return plan_.kernels(lanes_); }

}  // namespace skybody
