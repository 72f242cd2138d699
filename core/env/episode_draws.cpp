#include "core/env/episode_draws.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/math/random.h"
#include "core/base/simd/lane_mask.h"
#include "core/env/contact_sensing.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_call.h"

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
  std::fill_n(work.draws.number.data(), work.lanes, number);
  return work.draws.number.data();
}

/// Numbers requested draws, so that they differ from one another and from the draws at the reset.
const std::uint64_t* number_requests(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) {
  std::uint64_t* requests = group.writable(kRequests);
  for (int lane = 0; lane < group.lanes(); ++lane) {
    if (((mask >> lane) & 1u) != 0) ++requests[lane];
    work.draws.number[static_cast<std::size_t>(lane)] = kRequestedDraw | requests[lane];
  }
  return work.draws.number.data();
}

/// Whether randomizers write mass properties of bodies.
bool draws_bodies(const ScenarioModel& model) {
  for (const PluginInstance& r : model.of(SKYBODY_RANDOMIZER)) {
    for (const int param : r.writes) {
      for (const int first : model.layout().body_params) {
        if (param >= first && param < first + kBodyParamCount) return true;
      }
    }
  }
  return false;
}

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

EpisodeDraws::EpisodeDraws(const ScenarioModel& model, const EpisodeStart& start,
                           const StartOverlaps* overlaps)
    : model_(model), start_(start), overlaps_(overlaps), draws_bodies_(draws_bodies(model)) {
  for (const PluginInstance& r : model.of(SKYBODY_RANDOMIZER))
    draws_in_time_ |= r.randomizer.draws_in_time;
}

/// Only lanes with possible contact are checked one by one: nearly all robots begin in the air.
void EpisodeDraws::draw_start(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const {
  group.refresh(mask, work.physics);  // randomizers may read the bodies
  std::uint32_t asked = 0;
  each_lane(mask, [&](int lane) {
    if (!work.requests[static_cast<std::size_t>(lane)].empty()) asked |= 1u << lane;
  });
  if (!model_.of(SKYBODY_RANDOMIZER).empty() || asked != 0) {
    if (!model_.drawn_words.empty()) keep_undrawn(group, work);
    draw_with_requests(group, work, model_.view(group, work, mask), 0);
    group.refresh(mask, work.physics);
    std::uint32_t doubtful = group.unphysical() & (draws_bodies_ ? mask : asked);
    if (overlaps_ != nullptr) doubtful |= group.may_touch(mask, work.physics);
    each_lane(doubtful, [&](int lane) { draw_again(group, work, lane); });
  }
  draw_task(group, work, mask);
  each_lane(asked, [&](int lane) {
    const std::size_t count = work.requests[static_cast<std::size_t>(lane)].size();
    group.writable(kRequests)[lane] += count;
  });
}

/// Runs the randomizers in order. Clamps their values to each parameter's declared bounds and
/// places the robots at the drawn starts.
void EpisodeDraws::draw(StateGroup& group, const SkybodyLanes& lanes,
                        SkybodyOccasion occasion) const {
  const StateLayout& l = model_.layout();
  const std::uint32_t mask = lanes.active;
  const SkybodyStart where{group.writable(l.q, mask), group.writable(l.u, mask),
                           group.writable(l.rotor_speed, mask), group.writable(l.params, mask),
                           static_cast<std::uint32_t>(occasion)};
  for (const PluginInstance& r : model_.of(SKYBODY_RANDOMIZER)) {
    call_plugin(r.kernels.randomize, r, group, lanes, no_sizes, &where);
    for (const int param : r.writes) hold_to_bounds(group, mask, param);
    model_.starts.place(group, mask, r.randomizer.starts);
  }
}

/// The randomizers' draws at a reset, then the callers' requests.
void EpisodeDraws::draw_with_requests(StateGroup& group, const GroupWorkspace& work,
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
      put_request(model_.layout(), group, lane, {++number, repetition}, *request,
                  {0, model_.layout().params.size});
      model_.starts.place(group, 1u << lane, request->starts());
    }
  });
}

/// Lets the task draw its own parameters after the robots are placed. Callers' requests override
/// these draws.
void EpisodeDraws::draw_task(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const {
  if (model_.task().kernels.randomize == nullptr) return;
  const StateLayout& l = model_.layout();
  const SkybodyStart where{group.unmarked(l.q), group.unmarked(l.u), group.unmarked(l.rotor_speed),
                           group.unmarked(l.params), SKYBODY_AT_RESET};
  const SkybodyLanes lanes = model_.view(group, work, mask);
  call_plugin(model_.task().kernels.randomize, model_.task(), group, lanes, no_sizes, &where);
  for (const int param : model_.task().writes) hold_to_bounds(group, mask, param);
  each_lane(mask, [&](int lane) {
    std::uint64_t number = group.bits(kRequests)[lane];
    for (const auto& request : work.requests[static_cast<std::size_t>(lane)]) {
      const auto repetition = static_cast<int>(group.bits(kRedraws)[lane]);
      put_request(l, group, lane, {++number, repetition}, *request, model_.task_params);
    }
  });
}

/// Repeats the draws while the lane's bodies are not physical or its robots begin inside something.
/// All randomizers draw again from the state before the reset, with the random numbers of this
/// repetition. If the last repetition fails too, the lane gets a fault: of the first step for
/// bodies, of the start for overlaps.
void EpisodeDraws::draw_again(StateGroup& group, GroupWorkspace& work, int lane) const {
  const std::uint32_t mask = 1u << lane;
  const auto is_unphysical = [&] { return (group.unphysical() & mask) != 0; };
  const auto look = [&] {
    return is_unphysical() || overlaps_ == nullptr ? std::nullopt : find_overlap(group, work, lane);
  };
  std::optional<StartOverlap> overlap = look();
  int unchanged = 0, of_bodies = 0, of_places = 0;
  for (int k = 1;; ++k) {
    if (is_unphysical()) {
      if (++of_bodies > kMostBodyDraws) return;
    } else if (!overlap || ++of_places > model_.scenario().contact.redraws ||
               unchanged >= kMostUnchanged) {
      break;
    }
    group.writable(kRedraws)[lane] = static_cast<std::uint64_t>(k);
    const std::optional<StartOverlap> before = overlap;
    put_back_undrawn(group, work, lane);
    start_.place(group, lane);
    model_.starts.place(group, mask);
    group.refresh(mask, work.physics);
    SkybodyLanes lanes = model_.view(group, work, mask);
    lanes.physics_step = number_repetition(work, k);
    draw_with_requests(group, work, lanes, k);
    group.refresh(mask, work.physics);
    overlap = look();
    unchanged = overlap && before && *overlap == *before ? unchanged + 1 : 0;
  }
  if (!overlap) return;
  work.faults.bad_start |= mask;
  work.faults.start_status[static_cast<std::size_t>(lane)] = overlaps_->status(*overlap);
}

/// Empty if the dynamics fails: the first step is a fault then.
std::optional<StartOverlap> EpisodeDraws::find_overlap(StateGroup& group, GroupWorkspace& work,
                                                       int lane) const {
  try {
    ContactSensing::find(group, work, lane);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
  return overlaps_->find(work.contacts);
}

/// Saves the words that draws change and a reset does not restore: parameters that persist until
/// the next due draw, and the randomizers' own words, which count resets.
void EpisodeDraws::keep_undrawn(const StateGroup& group, GroupWorkspace& work) const {
  std::uint64_t* to = work.draws.undrawn.data();
  for (const int word : model_.drawn_words) to = std::copy_n(group.bits(word), group.lanes(), to);
}

void EpisodeDraws::put_back_undrawn(StateGroup& group, const GroupWorkspace& work, int lane) const {
  const std::uint64_t* from = work.draws.undrawn.data() + lane;
  for (const int word : model_.drawn_words) {
    std::memcpy(group.writable({word, 1}, 1u << lane) + lane, from, sizeof *from);
    from += group.lanes();
  }
}

void EpisodeDraws::draw_in_time(StateGroup& group, GroupWorkspace& work,
                                const SkybodyLanes& lanes) const {
  const StateLayout& l = model_.layout();
  const int width = group.lanes();
  for (const PluginInstance& r : model_.of(SKYBODY_RANDOMIZER)) {
    if (!r.randomizer.draws_in_time) continue;
    const SkybodyStart where{group.unmarked(l.q), group.unmarked(l.u),
                             group.unmarked(l.rotor_speed), group.unmarked(l.params),
                             SKYBODY_IN_TIME};
    double* before = work.draws.in_time.data();
    for (const int param : r.writes)
      before = std::copy_n(where.params + param * width, width, before);
    call_plugin(r.kernels.randomize, r, group, lanes, no_sizes, &where);
    std::uint32_t changed = 0;
    before = work.draws.in_time.data();
    for (const int param : r.writes) {
      const double* now = where.params + param * width;
      each_lane(lanes.active, [&](int lane) {
        if (std::memcmp(now + lane, before + lane, sizeof *now) != 0) changed |= 1u << lane;
      });
      before += width;
    }
    if (changed == 0) continue;
    for (const int param : r.writes) hold_to_bounds(group, changed, param);
    group.refresh(changed, work.physics);
  }
}

void EpisodeDraws::hold_to_bounds(StateGroup& group, std::uint32_t mask, int param) const {
  const EnvParam& info = model_.layout().param_info[static_cast<std::size_t>(param)];
  double* values = group.writable({model_.layout().params.offset + param, 1}, mask);
  each_lane(mask, [&](int lane) {
    double& value = values[lane];
    value = std::isfinite(value) ? std::clamp(value, info.min, info.max) : info.nominal;
  });
}

void EpisodeDraws::apply(StateGroup& group, GroupWorkspace& work, int lane,
                         const ParamRequest& request) const {
  if (request.redraws()) randomize(group, work, 1u << lane);
  if (request.changes().empty()) return;
  const std::uint64_t number = ++group.writable(kRequests)[lane];
  put_request(model_.layout(), group, lane, {number}, request, {0, model_.layout().params.size});
}

void EpisodeDraws::randomize(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const {
  group.refresh(mask, work.physics);
  if (model_.of(SKYBODY_RANDOMIZER).empty()) return;
  // Motion continues: a randomizer that also places robots must not move them now.
  const StateLayout& l = model_.layout();
  std::vector<double> motion;
  for (const Block& block : {l.q, l.u, l.rotor_speed}) {
    const double* values = group.reals(block);
    motion.insert(motion.end(), values, values + block.size * group.lanes());
  }
  SkybodyLanes lanes = model_.view(group, work, mask);
  lanes.physics_step = number_requests(group, work, mask);
  draw(group, lanes, SKYBODY_ON_REQUEST);
  const double* from = motion.data();
  for (const Block& block : {l.q, l.u, l.rotor_speed}) {
    std::copy(from, from + block.size * group.lanes(), group.writable(block, mask));
    from += block.size * group.lanes();
  }
  group.refresh(mask, work.physics);
}

}  // namespace skybody
