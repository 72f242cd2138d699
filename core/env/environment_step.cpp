// One transition, phase by phase (paper eq. 3): act, K times (control, advance, sense), conclude.
// Under direct control the phases are called one by one.
#include <algorithm>

#include "core/base/error.h"
#include "core/base/fp_environment.h"
#include "core/base/hash.h"
#include "core/base/octets.h"
#include "core/env/environment.h"
#include "core/env/group_lanes.h"
#include "core/env/group_rows.h"
#include "core/env/group_work.h"
#include "core/physics/step/lane_values.h"

namespace skybody {
namespace {

static_assert(kGroupLanes == SKYBODY_GROUP_LANES, "plugins are made for other groups");

}  // namespace

void Environment::step(StateGroup& group, GroupWork& work, std::uint32_t mask, const float* actions,
                       int action_stride, const Rows& rows) const {
  check(group, work, mask);
  work.bad_action = work.bad_state = 0;
  group.refresh(mask, work.physics);
  const SkybodyLanes lanes = view(group, mask);
  act(group, work, lanes, actions, action_stride);
  fly(group, work, lanes, scenario().stepping.action_repeat);
  count(group, kStep, mask);
  evaluate(group, work, lanes, rows.info != nullptr);
  conclude(group, work, mask, false, rows);
}

/// Physics steps; returns the lanes that came through.
std::uint32_t Environment::fly(StateGroup& group, GroupWork& work, SkybodyLanes lanes,
                               std::int64_t steps) const {
  for (std::int64_t k = 0; k < steps && lanes.active != 0; ++k) {
    control(group, work, lanes);
    lanes.active = advance(group, work, lanes.active);
    sense(group, lanes, false);
  }
  return lanes.active;
}

void Environment::check(const StateGroup& group, const GroupWork& work, std::uint32_t mask) const {
  SKYBODY_DEMAND(work.lanes == group.lanes(), "a work of another group size");
  SKYBODY_DEMAND(group.lanes() >= 32 || (mask >> group.lanes()) == 0, "a mask beyond the group");
}

SkybodyLanes Environment::view(const StateGroup& group, std::uint32_t mask) const {
  const Layout& l = layout();
  SkybodyLanes v{};
  v.lanes = static_cast<std::uint32_t>(group.lanes());
  v.active = mask;
  v.key = group.bits(kSeed);
  v.episode = group.bits(kEpisode);
  v.step = group.bits(kStep);
  v.physics_step = group.bits(kPhysicsStep);
  v.bodies = group.bodies();
  v.bodies_before = l.bodies_before.size > 0 ? group.reals(l.bodies_before) : nullptr;
  v.q = group.reals(l.q);
  v.u = group.reals(l.u);
  v.rotor_speed = group.reals(l.rotor_speed);
  v.params = group.reals(l.params);
  v.sensors = group.reals(l.sensors);
  v.action = group.reals(l.action);
  v.command = group.reals(l.command);
  return v;
}

void Environment::update(StateGroup& group, GroupWork& work, std::uint32_t mask) const {
  group.refresh(mask, work.physics);
}

/// P_i: clip the action and turn it into the command, once. A row that is not finite keeps the last
/// action instead and makes this transition a fault.
void Environment::act(StateGroup& group, GroupWork& work, const SkybodyLanes& view,
                      const float* actions, int action_stride) const {
  const Layout& l = layout();
  const int lanes = group.lanes();
  const std::uint32_t mask = view.active;
  const RowKernels& kernels = row_kernels();
  double* action = group.writable(l.action, mask);
  work.bad_action =
      mask & ~kernels.read_clipped(mask, lanes, actions, action_stride, l.action.size, action);
  double* command = group.writable(l.command, mask);
  if (task_.kernels.process != nullptr) {
    task_.kernels.process(task_.self.get(), &view, group.plugin_bits(task_.state),
                          group.plugin_reals(task_.buffer), action, command);
    return;
  }
  for (const ControllerChain& chain : chains_) {
    if (chain.count == 0) continue;
    const PluginInstance& first = controllers_[static_cast<std::size_t>(chain.first)];
    kernels.scale(mask, lanes, action + chain.action * lanes, first.input_count(), first.low.data(),
                  first.high.data(), command + chain.command * lanes);
  }
}

/// C_i: every robot's controllers in order, from the latest state.
void Environment::control(StateGroup& group, GroupWork& work, const SkybodyLanes& view) const {
  const int lanes = group.lanes();
  const bool serves_all = view.active == group.occupied();
  for (const ControllerChain& chain : chains_) {
    const double* input = group.reals(layout().command) + chain.command * lanes;
    for (int i = 0; i < chain.count; ++i) {
      const PluginInstance& c = controllers_[static_cast<std::size_t>(chain.first + i)];
      const bool is_last = i + 1 == chain.count;
      double* target = is_last ? actuator(group, view.active, c, chain) : nullptr;
      // All lanes at once go where they belong; else others' commands have to be spared.
      double* output = is_last && serves_all ? target : work.signal[i & 1].data();
      c.kernels.control(c.self.get(), &view, group.plugin_bits(c.state),
                        group.plugin_reals(c.buffer), input, output);
      input = output;
      if (is_last && !serves_all) keep(group, view.active, c.output_count, output, target);
    }
  }
}

/// Where the last controller's output goes: rotors, wrench sites or the base's drive.
double* Environment::actuator(StateGroup& group, std::uint32_t mask, const PluginInstance& last,
                              const ControllerChain& chain) const {
  const Layout& l = layout();
  const int lanes = group.lanes();
  if (last.output_signal == SKYBODY_ROTOR_SPEED) {
    const int first = l.robots[static_cast<std::size_t>(last.robot)].first_rotor;
    return group.writable(l.rotor_command, mask) + first * lanes;
  }
  if (last.output_signal == SKYBODY_WRENCH)
    return group.writable(l.wrench, mask) + 6 * chain.site * lanes;
  const int skip = last.output_signal == SKYBODY_VELOCITY ? 0 : 6;
  return group.writable(l.drive, mask) + (13 * chain.drive + skip) * lanes;
}

/// x_{k-1} -> x_k with the command held; lanes whose physics gives up stay in their last finite
/// state.
/// @returns the lanes that came through
std::uint32_t Environment::advance(StateGroup& group, GroupWork& work, std::uint32_t mask) const {
  remember_bodies(group, mask);
  const std::uint32_t through = group.advance(mask, work.physics);
  work.bad_state |= mask & ~through;
  count(group, kPhysicsStep, through);
  return through;
}

/// For plugins that look at where bodies were before the last physics step.
void Environment::remember_bodies(StateGroup& group, std::uint32_t mask) const {
  if (!needs_bodies_before_) return;
  const Block& block = layout().bodies_before;
  keep(group, mask, block.size, group.bodies(), group.writable(block, mask));
}

/// Sensors that are due after this physics step, each lane by its own count; all of them at a
/// reset.
void Environment::sense(StateGroup& group, const SkybodyLanes& lanes_now, bool all) const {
  if (sensors_.empty() || lanes_now.active == 0) return;
  const int lanes = group.lanes();
  const std::uint64_t* count = group.bits(kPhysicsStep);
  for (const PluginInstance& s : sensors_) {
    std::uint32_t due = 0;
    each_lane(lanes_now.active, [&](int lane) {
      if (all || count[lane] % static_cast<std::uint64_t>(s.period) == 0) due |= 1u << lane;
    });
    if (due == 0) continue;
    SkybodyLanes v = lanes_now;
    v.active = due;
    v.images = group.images().bytes() + s.images;
    v.image_stride = 8 * image_words_;
    s.kernels.sense(s.self.get(), &v, group.plugin_bits(s.state), group.plugin_reals(s.buffer),
                    group.writable(layout().sensors, due) + s.output * lanes);
  }
}

/// Psi_i: what the task says about the final state.
void Environment::evaluate(StateGroup& group, GroupWork& work, const SkybodyLanes& view,
                           bool wants_info) const {
  work.clear_outcome(wants_info);
  AlignedArray<double>& values = plan_.is_task_in_place ? work.observation : work.task_values;
  const SkybodyEvaluation out{values.data(),    work.reward.data(),
                              work.end.data(),  work.robot_reward.data(),
                              work.info.data(), wants_info ? 1u : 0u};
  task_.kernels.evaluate(task_.self.get(), &view, group.plugin_bits(task_.state),
                         group.plugin_reals(task_.buffer), &out);
  gather_observation(group, work);
}

/// Puts the observation together where the task has not written all of it to its place.
void Environment::gather_observation(const StateGroup& group, GroupWork& work) const {
  const int lanes = group.lanes();
  for (const ObservationPart& part : plan_.parts) {
    const double* values =
        part.is_of_task ? work.task_values.data() : group.reals(layout().sensors);
    std::copy_n(values + part.from * lanes, part.count * lanes,
                work.observation.data() + part.to * lanes);
  }
}

void Environment::goal(StateGroup& group, GroupWork& work, int lane,
                       std::vector<double>& out) const {
  const FpEnvironment guard;
  update(group, work, 1u << lane);
  out.assign(task_.goals.size() * 4, 0.0);
  if (task_.kernels.goal == nullptr || out.empty()) return;
  const auto lanes = static_cast<std::size_t>(group.lanes());
  std::vector<double> values(out.size() * lanes);
  const SkybodyLanes v = view(group, 1u << lane);
  task_.kernels.goal(task_.self.get(), &v, group.plugin_bits(task_.state),
                     group.plugin_reals(task_.buffer), values.data());
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k] = values[k * lanes + static_cast<std::size_t>(lane)];
  }
}

void Environment::hash(const StateGroup& group, int lane, const Rows& rows,
                       HashChain& chain) const {
  const auto lanes = static_cast<std::size_t>(group.lanes());
  const std::uint64_t* words = group.bits(0) + lane;
  for (int k = 0; k < layout().words; ++k) {
    chain.update(one_nan(words[static_cast<std::size_t>(k) * lanes]));
  }
  const float* row = rows.observation + static_cast<std::ptrdiff_t>(lane) * observation_size();
  for (int k = 0; k < observation_size(); ++k) chain.update(static_cast<double>(row[k]));
  const float* critic = rows.privileged + static_cast<std::ptrdiff_t>(lane) * privileged_size();
  for (int k = 0; k < privileged_size(); ++k) chain.update(static_cast<double>(critic[k]));
  for (const std::uint64_t word : group.images().of(lane)) chain.update(word);
  chain.update(static_cast<double>(rows.reward[lane]));
  chain.update(rows.status[lane]);
}

}  // namespace skybody
