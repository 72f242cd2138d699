// Steps of a group: kernels take the lanes that go on the tree's algorithms, all at once. Lanes
// that go by themselves (LaneStepper) are copied to a group of one lane and back: on Simbody, if
// only while something is within reach, and with integrators that choose their own times.
#include "core/physics/step/group_stepper.h"

#include <bit>
#include <cstring>

#include "core/base/error.h"
#include "core/base/octets.h"
#include "core/physics/step/lane_stepper.h"
#include "core/physics/step/step_plan.h"

namespace skybody {

/// The lanes of a group one at a time.
class GroupStepper::Alone {
 public:
  Alone(const StepPlan& plan, int lanes) : plan_(plan), steppers_(static_cast<std::size_t>(lanes)) {
    const Layout& layout = plan.world.layout;
    int total = plan.derived.size;
    for (const StateBlock& b : kStateBlocks) total += (layout.*b.place).size;
    for (const InputBlock& b : kInputBlocks) total += (layout.*b.place).size;
    for (const Block& b : layout.held) total += b.size;
    values_.resize(static_cast<std::size_t>(total) + 13 * plan.world.bodies.size());
  }

  bool advance(const GroupBlocks& group, int lane, const double* derived, bool on_simbody) {
    if (!stepper(lane).advance(take(group, lane, derived), on_simbody)) return false;
    for (const StateBlock& b : kStateBlocks) {
      give(one_.*b.values, (plan_.world.layout.*b.place).size, group.lanes, group.*b.values + lane);
    }
    return true;
  }
  void accelerations(const GroupBlocks& group, int lane, const double* derived, bool on_simbody,
                     double* udot) {
    stepper(lane).accelerations(take(group, lane, derived), on_simbody, udot);
  }
  void joint_reactions(const GroupBlocks& group, int lane, const double* derived, bool on_simbody,
                       SpatialForce<double>* out) {
    stepper(lane).joint_reactions(take(group, lane, derived), on_simbody, out);
  }
  void add_contacts(const GroupBlocks& group, int lane, std::vector<Contact>& out) {
    stepper(lane).add_contacts(take(group, lane, nullptr), out);
  }

 private:
  LaneStepper& stepper(int lane) {
    auto& stepper = steppers_[static_cast<std::size_t>(lane)];
    if (stepper == nullptr) stepper = std::make_unique<LaneStepper>(plan_);
    return *stepper;
  }

  /// A lane as a group of its own; bodies are left out.
  StepCall take(const GroupBlocks& group, int lane, const double* derived) {
    const Layout& layout = plan_.world.layout;
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
    double* mine = derived == nullptr ? nullptr : copy(derived, plan_.derived.size);
    one_.bodies = next;
    return {&plan_, &one_, nullptr, mine, nullptr};
  }
  static void give(const double* from, int count, int lanes, double* to) {
    for (int k = 0; k < count; ++k, to += lanes) *to = from[k];
  }

  const StepPlan& plan_;
  std::vector<std::unique_ptr<LaneStepper>> steppers_;
  std::vector<double> values_;  ///< that `one_` points into
  GroupBlocks one_;
};

GroupStepper::GroupStepper(const StepPlan& plan, int lanes)
    : plan_(plan),
      lanes_(lanes),
      spins_(plan.free_robots ? 0
                              : 3 * plan.world.bodies.size() * static_cast<std::size_t>(lanes)) {
  SKYBODY_DEMAND(lanes == 1 || (lanes == kGroupLanes && plan.has_kernels()),
                 "a group has 1 or 32 lanes");
  if (plan.has_held) make_derived();  // its kernels read each lane's own
}

GroupStepper::~GroupStepper() = default;

StepCall GroupStepper::call(const GroupBlocks& group, PhysicsScratch& scratch) {
  const bool is_shared = drawn_ == 0 && !plan_.has_held;
  return {&plan_, &group, spins_.data(), is_shared ? nullptr : derived_.data(), scratch.data()};
}

void GroupStepper::refresh(const GroupBlocks& group, std::uint32_t lanes, std::uint32_t drawn,
                           PhysicsScratch& scratch) {
  std::uint32_t own = 0;
  each_lane(drawn, [&](int l) {
    if (derive_bodies(group, l, scratch)) own |= 1u << l;
  });
  const StepCall all = call(group, scratch);
  if (own != 0) kernels().derive(all, own);
  each_lane(own, [&](int l) { remember_params(group, l); });
  kernels().refresh(all, lanes);
}

std::uint32_t GroupStepper::advance(const GroupBlocks& group, std::uint32_t lanes,
                                    PhysicsScratch& scratch) {
  const StepCall all = call(group, scratch);
  const std::uint32_t on_simbody = on_simbody_of(all, lanes);
  const std::uint32_t on_tree = lanes & ~broken_ & ~on_simbody;
  const std::uint32_t alone = plan_.has_kernels() ? on_simbody : on_simbody | on_tree;
  const std::uint32_t in_kernels = on_tree & ~alone;
  std::uint32_t through = in_kernels == 0 ? 0 : kernels().advance(all, in_kernels);
  if (alone != 0) through |= advance_alone(all, alone, on_simbody);
  note_step(lanes, on_simbody);
  return through;
}

/// What only kernels keep (bodies, spins) is made anew for lanes that went by themselves.
std::uint32_t GroupStepper::advance_alone(const StepCall& all, std::uint32_t lanes,
                                          std::uint32_t on_simbody) {
  std::uint32_t through = 0;
  each_lane(lanes, [&](int l) {
    const bool simbody = ((on_simbody >> l) & 1u) != 0;
    if (alone().advance(*all.group, l, all.derived, simbody)) through |= 1u << l;
  });
  kernels().refresh(all, through);
  return through;
}

/// The lanes that Simbody has to step.
std::uint32_t GroupStepper::on_simbody_of(const StepCall& all, std::uint32_t lanes) const {
  if (plan_.use == DynamicsUse::kSimbody) return lanes;
  const bool may = plan_.use == DynamicsUse::kHandOver && plan_.reach.is_possible();
  return may ? kernels().within_reach(all, lanes) : 0;
}

void GroupStepper::note_step(std::uint32_t lanes, std::uint32_t on_simbody) {
  on_simbody_ = on_simbody;
  const auto simbody = static_cast<std::uint64_t>(std::popcount(on_simbody));
  counts_.simbody += simbody;
  counts_.tree += static_cast<std::uint64_t>(std::popcount(lanes)) - simbody;
}

void GroupStepper::accelerations(const GroupBlocks& group, int lane, PhysicsScratch& scratch,
                                 double* udot) {
  if (((broken_ >> lane) & 1u) != 0) make_bodies(group, lane, scratch);  // throws
  const StepCall all = call(group, scratch);
  alone().accelerations(group, lane, all.derived, on_simbody_of(all, 1u << lane) != 0, udot);
}

void GroupStepper::joint_reactions(const GroupBlocks& group, int lane, PhysicsScratch& scratch,
                                   SpatialForce<double>* out) {
  if (((broken_ >> lane) & 1u) != 0) make_bodies(group, lane, scratch);  // throws
  const StepCall all = call(group, scratch);
  alone().joint_reactions(group, lane, all.derived, on_simbody_of(all, 1u << lane) != 0, out);
}

void GroupStepper::add_contacts(const GroupBlocks& group, int lane, PhysicsScratch& scratch,
                                std::vector<Contact>& out) {
  if (on_simbody_of(call(group, scratch), 1u << lane) == 0) return;
  alone().add_contacts(group, lane, out);
}

/// Recomputes a lane's body constants if its parameters have changed and are not nominal.
/// @returns true if the rotors' must follow
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
  } catch (const std::runtime_error&) {  // no body has such masses: this lane's steps fail
    broken_ |= bit;
    return false;
  }
  return true;
}

/// @returns DerivedLayout::size values in scratch, of which the bodies' are made
/// @throws Error (naming the body) if no rigid body can have the lane's mass properties
const double* GroupStepper::make_bodies(const GroupBlocks& group, int lane,
                                        PhysicsScratch& scratch) const {
  auto* params = reinterpret_cast<double*>(scratch.data());
  double* derived = params + plan_.world.layout.physics_params;
  for (int k = 0; k < plan_.world.layout.physics_params; ++k)
    params[k] = group.params[k * lanes_ + lane];
  make_body_constants(plan_.world, params, derived + plan_.derived.bodies);
  return derived;
}

/// Says that the lane's numbers follow from its present parameters.
void GroupStepper::remember_params(const GroupBlocks& group, int lane) {
  known_ |= 1u << lane;
  for (int k = 0; k < plan_.world.layout.physics_params; ++k) {
    made_from_[static_cast<std::size_t>(k * lanes_ + lane)] = group.params[k * lanes_ + lane];
  }
}

/// Whether parameters that physics reads have the same bits.
/// @param mine    of one lane of a group
/// @param stride  of `others`
bool GroupStepper::are_params(const double* mine, const double* others, int stride) const {
  for (int k = 0; k < plan_.world.layout.physics_params; ++k, mine += lanes_, others += stride) {
    if (std::memcmp(mine, others, sizeof(double)) != 0) return false;
  }
  return true;
}

/// Made where a lane is first drawn: most worlds never need it.
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

/// The values from place `first` on.
void GroupStepper::put_derived(const double* derived, int first, int lane) {
  for (int k = first; k < plan_.derived.size; ++k) {
    derived_[static_cast<std::size_t>(k * lanes_ + lane)] = derived[k];
  }
}

GroupStepper::Alone& GroupStepper::alone() {
  if (!alone_) alone_ = std::make_unique<Alone>(plan_, lanes_);
  return *alone_;
}

const StepKernels& GroupStepper::kernels() const { return plan_.kernels(lanes_); }

}  // namespace skybody
