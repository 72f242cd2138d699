// Randomizer draws: at a reset, again if robots would begin inside something, and on request.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/base/math/random.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "core/env/compiled_scenario.h"
#include "core/env/fault_cause.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_call.h"
#include "core/env/start_overlaps.h"
#include "core/model/fault_reason.h"
#include "core/physics/bodies/checked_mass.h"

namespace skybody {
namespace {

/// Draws outside the step loop use counters in place of the physics step, above all possible steps:
/// one range for requested draws, one for repeated draws of a start.
constexpr std::uint64_t kRequestedDraw = std::uint64_t{1} << 63;
constexpr std::uint64_t kRepeatedDraw = std::uint64_t{1} << 62;

/// Greatest number of repeated draws for bodies whose mass properties are not physical. With
/// inertia drawn axis by axis, up to a quarter of all draws may be such.
constexpr int kMostBodyDraws = 64;

/// After this many draws that leave the worst overlap unchanged, to the bit, no drawn value can
/// move it. Draws from a small set of places may well repeat several times.
constexpr int kMostUnchanged = 4;

/// The number of a repetition, the same for all lanes.
const std::uint64_t* number_repetition(GroupWorkspace& work, int repetition) {
  const std::uint64_t number = kRepeatedDraw | static_cast<std::uint64_t>(repetition);
  std::fill_n(work.request.data(), work.lanes, number);
  return work.request.data();
}

}  // namespace

/// Collects the state words that draws change, and the overlaps in the scenario's own start.
void CompiledScenario::look_for_bad_starts() {
  const std::vector<PluginInstance>& randomizers = plugins_[SKYBODY_RANDOMIZER];
  const bool may_overlap = scenario().contact.redraws > 0 && count_bristles(*world_) > 0;
  for (const PluginInstance& r : randomizers) {
    for (int k = r.state; k < r.state + r.state_words + r.buffer_words; ++k) {
      drawn_words_.push_back(layout().plugin_state.offset + k);
    }
    for (const int param : r.writes) drawn_words_.push_back(layout().params.offset + param);
  }
  if (!may_overlap) return;
  StateGroup group = make_state(1);
  const std::unique_ptr<GroupWorkspace> work = make_workspace(1);
  initialize(group, 0, 0, 0);
  start_overlaps_ = std::make_unique<const StartOverlaps>(*world_, contacts(group, *work, 0));
}

/// Whether randomizers write mass properties of bodies.
bool CompiledScenario::draws_bodies() const {
  for (const PluginInstance& r : plugins_[SKYBODY_RANDOMIZER]) {
    for (const int param : r.writes) {
      for (const int first : layout().body_params) {
        if (param >= first && param < first + kBodyParamCount) return true;
      }
    }
  }
  return false;
}

/// kBadState with the index of the body whose inertia is not physical, or else with the likely
/// cause.
std::uint64_t CompiledScenario::bad_state_bits(const StateGroup& group, int lane) const {
  std::array<double, kBodyParamCount> values;
  for (std::size_t b = 0; b < world_->bodies.size(); ++b) {
    const int first = layout().params.offset + layout().body_params[b];
    for (int k = 0; k < kBodyParamCount; ++k) {
      values[static_cast<std::size_t>(k)] = group.reals(first + k)[lane];
    }
    if (is_possible(mass_properties(values.data()))) continue;
    return kBadState | (static_cast<std::uint64_t>(b) + 1) << kBadStartPlace;
  }
  return kBadState | cause_bits(*world_, group, lane);
}

/// The message about a body whose inertia is not physical. @param status  that contains its index
std::string CompiledScenario::reason_of_body(std::uint64_t status) const {
  const int number = impossible_body(status);
  const WorldBody& body = world_->bodies[static_cast<std::size_t>(number)];
  const std::string path = "robots." +
                           scenario().robots[static_cast<std::size_t>(body.robot)].name +
                           ".links." + body.model->name;
  return "no rigid body has the mass, centre and inertia of `" + path +
         "`: a mass is above 0, and no principal moment above the sum of the other two; narrow "
         "what randomizers draw or callers set: its `.mass`, `.com[0]` and `.inertia[0]` to `[5]` "
         "are what state() reads until the next reset, and what a flight log has under `params`";
}

std::string CompiledScenario::fault_reason(std::uint64_t status) const {
  std::uint64_t told = 0;  // bits explained by a longer text
  std::string full;
  if (impossible_body(status) >= 0) {
    told = kBadState;
    full = reason_of_body(status);
  } else if ((status & kBadStart) != 0 && start_overlaps_ != nullptr) {
    told = kBadStart;
    full = start_overlaps_->reason(status);
  } else if (const std::string cause = cause_text(*world_, status); !cause.empty()) {
    told = kBadState;
    full = skybody::fault_reason(kFault | kBadState) + ": " + cause;
  }
  const std::string others = skybody::fault_reason(status & ~told);
  return others + (others.empty() || full.empty() ? "" : "; ") + full;
}

namespace {

/// The number of a draw within a request.
struct RequestNumber {
  std::uint64_t request;  ///< among all requests in this environment
  int repetition = 0;     ///< of a start that is drawn again

  std::uint64_t counter() const {
    return kRequestedDraw | (static_cast<std::uint64_t>(repetition) << 40) | request;
  }
};

/// Writes the values of a request. @param only  the parameters that may be written
void put_request(const StateLayout& layout, StateGroup& group, int lane, RequestNumber number,
                 const ParamRequest& request, Block only) {
  const RandomKey key{group.bits(kSeed)[lane], group.bits(kEnvId)[lane]};
  const Random<double> random(key, group.bits(kEpisode)[lane], number.counter(),
                              derive_stream("requests"));
  request.each_value(random, [&](int param, double value) {
    if (param < only.offset || param >= only.offset + only.size) return;
    const EnvParam& info = layout.param_info[static_cast<std::size_t>(param)];
    group.writable({layout.params.offset + param, 1}, 1u << lane)[lane] =
        std::clamp(value, info.min, info.max);
  });
}

}  // namespace

void CompiledScenario::apply(StateGroup& group, GroupWorkspace& work, int lane,
                             const ParamRequest& request) const {
  if (request.redraws()) randomize(group, work, 1u << lane);
  if (request.changes().empty()) return;
  const std::uint64_t number = ++group.writable(kRequests)[lane];
  put_request(layout(), group, lane, {number}, request, {0, layout().params.size});
}

/// The randomizers' draws at a reset, then the callers' requests.
void CompiledScenario::draw_with_requests(StateGroup& group, const GroupWorkspace& work,
                                          const SkybodyLanes& lanes, int repetition) const {
  draw(group, lanes, SKYBODY_AT_RESET);
  each_lane(lanes.active, [&](int lane) {
    std::uint64_t number = group.bits(kRequests)[lane];
    for (const auto& request : work.requests[static_cast<std::size_t>(lane)]) {
      if (request->redraws()) {
        SkybodyLanes one = lanes;
        one.active = 1u << lane;
        draw(group, one, SKYBODY_ON_REQUEST);
      }
      put_request(layout(), group, lane, {++number, repetition}, *request,
                  {0, layout().params.size});
      starts_.place(group, 1u << lane, request->starts());
    }
  });
}

/// Runs the randomizers in order. Clamps their values to each parameter's declared bounds and
/// places the robots at the drawn starts.
void CompiledScenario::draw(StateGroup& group, const SkybodyLanes& lanes,
                            SkybodyOccasion occasion) const {
  const StateLayout& l = layout();
  const std::uint32_t mask = lanes.active;
  const SkybodyStart where{group.writable(l.q, mask), group.writable(l.u, mask),
                           group.writable(l.rotor_speed, mask), group.writable(l.params, mask),
                           static_cast<std::uint32_t>(occasion)};
  for (const PluginInstance& r : plugins_[SKYBODY_RANDOMIZER]) {
    call_plugin(r.kernels.randomize, r, group, lanes, no_sizes, &where);
    for (const int param : r.writes) hold_to_bounds(group, mask, param);
    starts_.place(group, mask, r.starts);
  }
}

/// Runs the randomizers that draw before each physics step. Lanes without a change keep their
/// parameters and all data derived from them.
void CompiledScenario::draw_in_time(StateGroup& group, GroupWorkspace& work,
                                    const SkybodyLanes& lanes) const {
  const StateLayout& l = layout();
  const int width = group.lanes();
  for (const PluginInstance& r : plugins_[SKYBODY_RANDOMIZER]) {
    if (!r.draws_in_time) continue;
    const SkybodyStart where{group.unmarked(l.q), group.unmarked(l.u),
                             group.unmarked(l.rotor_speed), group.unmarked(l.params),
                             SKYBODY_IN_TIME};
    double* before = work.drawn.data();
    for (const int param : r.writes)
      before = std::copy_n(where.params + param * width, width, before);
    call_plugin(r.kernels.randomize, r, group, lanes, no_sizes, &where);
    std::uint32_t changed = 0;
    before = work.drawn.data();
    for (const int param : r.writes) {
      const double* now = where.params + param * width;
      each_lane(lanes.active, [&](int lane) {
        if (std::memcmp(now + lane, before + lane, sizeof *now) != 0) changed |= 1u << lane;
      });
      before += width;
    }
    if (changed == 0) continue;
    for (const int param : r.writes) hold_to_bounds(group, changed, param);
    update(group, work, changed);
  }
}

void CompiledScenario::hold_to_bounds(StateGroup& group, std::uint32_t mask, int param) const {
  const EnvParam& info = layout().param_info[static_cast<std::size_t>(param)];
  double* values = group.writable({layout().params.offset + param, 1}, mask);
  each_lane(mask, [&](int lane) {
    double& value = values[lane];
    value = std::isfinite(value) ? std::clamp(value, info.min, info.max) : info.nominal;
  });
}

/// Draws the start of an episode. Only lanes with possible contact are checked one by one: nearly
/// all robots begin in the air.
void CompiledScenario::draw_start(StateGroup& group, GroupWorkspace& work,
                                  std::uint32_t mask) const {
  update(group, work, mask);  // randomizers may read the bodies
  std::uint32_t asked = 0;
  each_lane(mask, [&](int lane) {
    if (!work.requests[static_cast<std::size_t>(lane)].empty()) asked |= 1u << lane;
  });
  if (!plugins_[SKYBODY_RANDOMIZER].empty() || asked != 0) {
    if (!drawn_words_.empty()) keep_undrawn(group, work);
    draw_with_requests(group, work, view(group, work, mask), 0);
    update(group, work, mask);
    std::uint32_t doubtful = group.unphysical() & (draws_bodies_ ? mask : asked);
    if (start_overlaps_ != nullptr) doubtful |= group.may_touch(mask, work.physics);
    each_lane(doubtful, [&](int lane) { draw_again(group, work, lane); });
  }
  draw_task(group, work, mask);
  each_lane(asked, [&](int lane) {
    const std::size_t count = work.requests[static_cast<std::size_t>(lane)].size();
    group.writable(kRequests)[lane] += count;
  });
}

/// Lets the task draw its own parameters after the robots are placed. Callers' requests override
/// these draws.
void CompiledScenario::draw_task(StateGroup& group, GroupWorkspace& work,
                                 std::uint32_t mask) const {
  if (task().kernels.randomize == nullptr) return;
  const StateLayout& l = layout();
  const SkybodyStart where{group.unmarked(l.q), group.unmarked(l.u), group.unmarked(l.rotor_speed),
                           group.unmarked(l.params), SKYBODY_AT_RESET};
  const SkybodyLanes lanes = view(group, work, mask);
  call_plugin(task().kernels.randomize, task(), group, lanes, no_sizes, &where);
  for (const int param : task().writes) hold_to_bounds(group, mask, param);
  each_lane(mask, [&](int lane) {
    std::uint64_t number = group.bits(kRequests)[lane];
    for (const auto& request : work.requests[static_cast<std::size_t>(lane)]) {
      const auto repetition = static_cast<int>(group.bits(kRedraws)[lane]);
      put_request(l, group, lane, {++number, repetition}, *request, task_params_);
    }
  });
}

/// Repeats the draws while the lane's bodies are not physical or its robots begin inside something.
/// All randomizers draw again from the state before the reset, with the random numbers of this
/// repetition. If the last repetition fails too, the lane gets a fault: of the first step for
/// bodies, of the start for overlaps.
void CompiledScenario::draw_again(StateGroup& group, GroupWorkspace& work, int lane) const {
  const std::uint32_t mask = 1u << lane;
  const auto is_unphysical = [&] { return (group.unphysical() & mask) != 0; };
  const auto look = [&] {
    return is_unphysical() || start_overlaps_ == nullptr ? std::nullopt
                                                         : find_overlap(group, work, lane);
  };
  std::optional<StartOverlap> overlap = look();
  int unchanged = 0, of_bodies = 0, of_places = 0;
  for (int k = 1;; ++k) {
    if (is_unphysical()) {
      if (++of_bodies > kMostBodyDraws) return;
    } else if (!overlap || ++of_places > scenario().contact.redraws ||
               unchanged >= kMostUnchanged) {
      break;
    }
    group.writable(kRedraws)[lane] = static_cast<std::uint64_t>(k);
    const std::optional<StartOverlap> before = overlap;
    put_back_undrawn(group, work, lane);
    place_at_start(group, lane);
    starts_.place(group, mask);
    update(group, work, mask);
    SkybodyLanes lanes = view(group, work, mask);
    lanes.physics_step = number_repetition(work, k);
    draw_with_requests(group, work, lanes, k);
    update(group, work, mask);
    overlap = look();
    unchanged = overlap && before && *overlap == *before ? unchanged + 1 : 0;
  }
  if (!overlap) return;
  work.bad_start |= mask;
  work.start_status[static_cast<std::size_t>(lane)] = start_overlaps_->status(*overlap);
}

/// Empty if the dynamics fails: the first step is a fault then.
std::optional<StartOverlap> CompiledScenario::find_overlap(StateGroup& group, GroupWorkspace& work,
                                                           int lane) const {
  try {
    find_contacts(group, work, lane);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
  return start_overlaps_->find(work.contacts);
}

/// Saves the words that draws change and a reset does not restore: parameters that persist until
/// the next due draw, and the randomizers' own words, which count resets.
void CompiledScenario::keep_undrawn(const StateGroup& group, GroupWorkspace& work) const {
  std::uint64_t* to = work.undrawn.data();
  for (const int word : drawn_words_) to = std::copy_n(group.bits(word), group.lanes(), to);
}

void CompiledScenario::put_back_undrawn(StateGroup& group, const GroupWorkspace& work,
                                        int lane) const {
  const std::uint64_t* from = work.undrawn.data() + lane;
  for (const int word : drawn_words_) {
    std::memcpy(group.writable({word, 1}, 1u << lane) + lane, from, sizeof *from);
    from += group.lanes();
  }
}

/// Numbers requested draws, so that they differ from one another and from the draws at the reset.
const std::uint64_t* CompiledScenario::number_requests(StateGroup& group, GroupWorkspace& work,
                                                       std::uint32_t mask) const {
  std::uint64_t* requests = group.writable(kRequests);
  for (int lane = 0; lane < group.lanes(); ++lane) {
    if (((mask >> lane) & 1u) != 0) ++requests[lane];
    work.request[static_cast<std::size_t>(lane)] = kRequestedDraw | requests[lane];
  }
  return work.request.data();
}

void CompiledScenario::randomize(StateGroup& group, GroupWorkspace& work,
                                 std::uint32_t mask) const {
  check(group, work, mask);
  const FpEnvironment guard;
  update(group, work, mask);
  if (plugins_[SKYBODY_RANDOMIZER].empty()) return;
  // Motion continues: a randomizer that also places robots must not move them now.
  const StateLayout& l = layout();
  std::vector<double> motion;
  for (const Block& block : {l.q, l.u, l.rotor_speed}) {
    const double* values = group.reals(block);
    motion.insert(motion.end(), values, values + block.size * group.lanes());
  }
  SkybodyLanes lanes = view(group, work, mask);
  lanes.physics_step = number_requests(group, work, mask);
  draw(group, lanes, SKYBODY_ON_REQUEST);
  const double* from = motion.data();
  for (const Block& block : {l.q, l.u, l.rotor_speed}) {
    std::copy(from, from + block.size * group.lanes(), group.writable(block, mask));
    from += block.size * group.lanes();
  }
  update(group, work, mask);
}

}  // namespace skybody
