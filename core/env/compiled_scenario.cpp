#include "core/env/compiled_scenario.h"

#include <algorithm>

#include "core/base/simd/fp_environment.h"
#include "core/base/simd/lane_mask.h"
#include "core/base/system/error.h"
#include "core/env/group_lanes.h"
#include "core/env/group_workspace.h"
#include "core/env/plugin_call.h"
#include "core/env/state_values.h"
#include "core/physics/world/lane_values.h"

namespace skybody {
namespace {

static_assert(kGroupLanes == SKYBODY_GROUP_LANES, "plugins are made for other groups");

void check(const StateGroup& group, const GroupWorkspace& work, std::uint32_t mask) {
  SKYBODY_DEMAND(work.lanes == group.lanes(), "a work of another group size");
  SKYBODY_DEMAND(group.lanes() >= 32 || (mask >> group.lanes()) == 0, "a mask beyond the group");
}

/// Calls the task's goal() or goal_motion(), `size` values per declared goal; null: zeros.
template <class Function>
void ask_goals(const ScenarioModel& model, StateGroup& group, GroupWorkspace& work, int lane,
               Function function, int size, const char* value, std::vector<double>& out) {
  const FpEnvironment guard;
  group.refresh(1u << lane, work.physics);
  out.assign(model.task().task.goals.size() * static_cast<std::size_t>(size), 0.0);
  if (function == nullptr || out.empty()) return;
  const auto lanes = static_cast<std::size_t>(group.lanes());
  std::vector<double> values(out.size() * lanes);
  const SkybodyLanes view = model.view(group, work, 1u << lane);
  call_plugin(
      function, model.task(), group, view,
      [&] {
        return CallSizes{0, static_cast<int>(out.size()), 0, value, values.data()};
      },
      values.data());
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k] = values[k * lanes + static_cast<std::size_t>(lane)];
  }
}

}  // namespace

CompiledScenario::CompiledScenario(Scenario scenario, PluginFactory& factory, Checking checking)
    : model_(build_scenario_model(std::move(scenario), factory, checking)),
      phases_(*model_),
      state_values_(std::make_unique<const StateValues>(*this)) {}

CompiledScenario::~CompiledScenario() = default;

std::unique_ptr<GroupWorkspace> CompiledScenario::make_workspace(int lanes) const {
  return model_->make_workspace(lanes);
}

// --- transitions --------------------------------------------------------------------------------

void CompiledScenario::step(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                            const float* actions, int action_stride, const Rows& rows) const {
  check(group, work, mask);
  work.faults.clear();
  update(group, work, mask);
  const SkybodyLanes lanes = model_->view(group, work, mask);
  phases_.control.apply_action(group, work, lanes, actions, action_stride);
  fly_action(group, work, lanes);
  count(group, kStep, mask);
  phases_.outcome.evaluate(group, work, lanes, rows.info != nullptr);
  phases_.outcome.finish(group, work, mask, false, rows);
}

/// The physics steps of an action.
void CompiledScenario::fly_action(StateGroup& group, GroupWorkspace& work,
                                  SkybodyLanes lanes) const {
  const int steps = scenario().stepping.action_repeat;
  const int period = task().period > 0 ? task().period : steps;  // of the command
  for (int k = 0; k < steps && lanes.active != 0; ++k) {
    if (k % period == 0) phases_.control.make_command(group, work, lanes);
    if (task().task.interpolates) {
      phases_.control.move_command(group, work, lanes.active, k % period + 1, period, k < period);
    }
    physics_step(group, work, lanes, steps - 1 - k);
  }
}

/// One physics step. Lanes that fail are removed from the active lanes.
/// @param steps_left  as SensingPhase::sense_due
void CompiledScenario::physics_step(StateGroup& group, GroupWorkspace& work, SkybodyLanes& lanes,
                                    std::int64_t steps_left) const {
  if (phases_.draws.draws_in_time()) phases_.draws.draw_in_time(group, work, lanes);
  phases_.control.control(group, work, lanes);
  phases_.effects.apply(group, lanes);
  lanes.active = phases_.physics.advance(group, work, lanes.active, steps_left);
  phases_.sensing.sense_due(group, lanes, steps_left);
}

void CompiledScenario::reset(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                             const Rows& rows) const {
  check(group, work, mask);
  work.faults.clear();
  phases_.start.begin(group, mask);
  phases_.draws.draw_start(group, work, mask);
  phases_.start.settle_joint_drives(group, mask);
  phases_.physics.remember_bodies(group, mask);
  phases_.contacts.sense(group, work, mask);
  phases_.start.reset_plugins(SKYBODY_CONTROLLER, group, work, mask);
  phases_.start.silence_rotors(group, mask);  // after controllers have read the initial speeds
  update(group, work, mask);
  phases_.contacts.sense_joint_reactions(group, work, mask);
  for (const SkybodyKind kind : {SKYBODY_TASK, SKYBODY_EFFECT, SKYBODY_SENSOR}) {
    phases_.start.reset_plugins(kind, group, work, mask);
  }
  const SkybodyLanes lanes = model_->view(group, work, mask);
  phases_.sensing.sense_all(group, lanes);
  phases_.outcome.evaluate(group, work, lanes, rows.info != nullptr);
  phases_.outcome.finish(group, work, mask, true, rows);
}

void CompiledScenario::hash(const StateGroup& group, int lane, const Rows& rows,
                            HashChain& chain) const {
  const auto lanes = static_cast<std::size_t>(group.lanes());
  const std::uint64_t* words = group.bits(0) + lane;
  const int first_observed = layout().last_observation.offset;
  const RowParts& observed = model_->observation.row;
  for (int k = 0; k < layout().words; ++k) {
    const int word = first_observed + observed.source_of(k - first_observed);
    chain.update(canonical_nan(words[static_cast<std::size_t>(word) * lanes]));
  }
  const float* row = rows.observation + static_cast<std::ptrdiff_t>(lane) * observation_size();
  for (int k = 0; k < observation_size(); ++k) chain.update(static_cast<double>(row[k]));
  const float* critic = rows.privileged + static_cast<std::ptrdiff_t>(lane) * privileged_size();
  for (int k = 0; k < privileged_size(); ++k) chain.update(static_cast<double>(critic[k]));
  for (const std::uint64_t word : group.images().of(lane)) chain.update(word);
  chain.update(static_cast<double>(rows.reward[lane]));
  chain.update(rows.status[lane]);
}

// --- direct control -----------------------------------------------------------------------------

std::uint32_t CompiledScenario::advance(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                                        std::int64_t physics_steps) const {
  check(group, work, mask);
  const FpEnvironment guard;
  update(group, work, mask);
  SkybodyLanes lanes = model_->view(group, work, mask);
  for (std::int64_t k = 0; k < physics_steps && lanes.active != 0; ++k) {
    physics_step(group, work, lanes, physics_steps - 1 - k);
  }
  each_lane(mask & ~lanes.active, [&](int lane) {
    group.writable(kStatus)[lane] =
        kTruncated | kFault | phases_.faults.bad_state_bits(group, lane);
  });
  return lanes.active;
}

void CompiledScenario::evaluate(StateGroup& group, GroupWorkspace& work, std::uint32_t mask,
                                const Rows& rows) const {
  check(group, work, mask);
  const FpEnvironment guard;
  work.faults.clear();
  count(group, kStep, mask);
  each_lane(mask, [&](int lane) {  // advance() has left its faults in the status
    if ((group.bits(kStatus)[lane] & kBadState) != 0) work.faults.bad_state |= 1u << lane;
  });
  update(group, work, mask);
  phases_.outcome.evaluate(group, work, model_->view(group, work, mask), rows.info != nullptr);
  phases_.outcome.finish(group, work, mask, false, rows);
}

void CompiledScenario::randomize(StateGroup& group, GroupWorkspace& work,
                                 std::uint32_t mask) const {
  check(group, work, mask);
  const FpEnvironment guard;
  phases_.draws.randomize(group, work, mask);
}

void CompiledScenario::apply(StateGroup& group, GroupWorkspace& work, int lane,
                             const ParamRequest& request) const {
  check(group, work, 1u << lane);
  const FpEnvironment guard;
  phases_.draws.apply(group, work, lane, request);
}

void CompiledScenario::update(StateGroup& group, GroupWorkspace& work, std::uint32_t mask) const {
  group.refresh(mask, work.physics);
  const std::uint32_t undrawn = group.take_undrawn(mask);
  if (undrawn != 0) phases_.sensing.draw_again(group, model_->view(group, work, undrawn));
}

void CompiledScenario::accelerations(StateGroup& group, GroupWorkspace& work, int lane,
                                     double* udot) const {
  const FpEnvironment guard;
  group.accelerations(lane, work.physics, udot);
}

std::vector<Contact> CompiledScenario::contacts(StateGroup& group, GroupWorkspace& work,
                                                int lane) const {
  const FpEnvironment guard;
  update(group, work, 1u << lane);
  ContactSensing::find(group, work, lane);
  return work.contacts;
}

// --- goals --------------------------------------------------------------------------------------

void CompiledScenario::goal(StateGroup& group, GroupWorkspace& work, int lane,
                            std::vector<double>& out) const {
  ask_goals(*model_, group, work, lane, task().kernels.goal, 4, "goal", out);
}

void CompiledScenario::goal_motion(StateGroup& group, GroupWorkspace& work, int lane,
                                   std::vector<double>& out) const {
  ask_goals(*model_, group, work, lane, task().kernels.goal_motion, 6, "goal motion", out);
}

}  // namespace skybody
