#include "app/flight.h"

#include <cstring>
#include <utility>

#include "app/interrupt.h"
#include "app/report/flight_record.h"
#include "app/report/progress_line.h"
#include "app/report/text_table.h"
#include "core/base/system/number_text.h"

namespace skybody {
namespace {

/// The task's reason for ending the episode, such as ": tilt" or ": success", from the infos
/// `success` and `failed.*`; empty for tasks without them.
std::string reason_of(const Simulation& simulation) {
  const std::span<const float> values = simulation.info();
  std::size_t k = 0;
  for (const Channel& channel : simulation.compiled().info_channels()) {
    const bool is_reason =
        channel.name == kSuccessInfo || channel.name.starts_with(kFailureInfoPrefix);
    if (is_reason && values[k] > 0.5F) {
      return ": " + channel.name.substr(channel.name.find('.') + 1);
    }
    k += static_cast<std::size_t>(channel.count);
  }
  return "";
}

/// Reason for the end of the episode; empty: it goes on.
std::string end_of(const RolloutPlan& plan, const Simulation& simulation) {
  if (simulation.fault())
    return "fault: " + simulation.compiled().fault_reason(simulation.status());
  if (simulation.terminated()) return "terminated" + reason_of(simulation);
  if (simulation.truncated()) return "truncated";
  if (InterruptGuard::signal() != 0) return "interrupted";
  if (simulation.steps() >= plan.most_steps) return "stopped";
  return "";
}

std::string progress(std::uint64_t episode, const RolloutPlan& plan, const Simulation& simulation,
                     const EpisodeSummary& summary) {
  const std::uint64_t percent = 100 * simulation.steps() / plan.most_steps;
  return "episode " + std::to_string(episode) + "/" + std::to_string(plan.episodes) + "  " +
         std::to_string(percent) + " %  step " + std::to_string(simulation.steps()) + "  " +
         fixed(simulation.time(), 1) + " s  return " + fixed(summary.total_reward, 3);
}

/// Logs an event for parameters that have changed in the episode since the last entry of `params`,
/// and adds an entry.
void note_changes(const Simulation& simulation, std::vector<std::vector<double>>& params,
                  FlightLog& log) {
  std::vector<double> now = simulation.params();
  const std::vector<double>& before = params.back();
  if (std::memcmp(now.data(), before.data(), now.size() * sizeof(double)) == 0) return;
  const std::vector<EnvParam>& infos = simulation.compiled().layout().param_info;
  for (std::size_t k = 0; k < now.size(); ++k) {
    if (now[k] != before[k]) log.event("drawn: " + infos[k].path + " = " + exact_text(now[k]));
  }
  params.push_back(std::move(now));
}

EpisodeSummary fly_episode(std::uint64_t number, const RolloutPlan& plan, Simulation& simulation,
                           Policy& policy, FlightLog& log, ProgressLine& line) {
  EpisodeSummary summary;
  ErrorWindow window(simulation.compiled());
  ReferenceErrors references(simulation.compiled());
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  const std::uint64_t clipped_before = policy.clipped();
  simulation.reset();
  summary.params = {simulation.params()};
  log.begin_episode(summary.params.front());
  record(simulation, log);
  summary.redraws = static_cast<std::uint64_t>(simulation.state("redraws")[0]);
  log.event(summary.redraws == 0
                ? "reset"
                : "reset, the start drawn again: " + std::to_string(summary.redraws));
  for (summary.end = end_of(plan, simulation); summary.end.empty();
       summary.end = end_of(plan, simulation)) {
    policy.act(simulation, action);
    simulation.step(action);
    record(simulation, log);
    note_changes(simulation, summary.params, log);
    add_infos(simulation, summary.infos);
    window.add(simulation);
    references.add(simulation);
    summary.total_reward += static_cast<double>(simulation.reward());
    if (line.is_due()) line.show(progress(number, plan, simulation, summary));
  }
  log.event(summary.end);
  summary.steps = simulation.steps();
  summary.clipped = policy.clipped() - clipped_before;
  summary.time = simulation.time();
  summary.goals = window.errors();
  summary.references = references.errors();
  return summary;
}

}  // namespace

std::vector<EpisodeSummary> fly(const RolloutPlan& plan, Simulation& simulation, Policy& policy,
                                FlightLog& log) {
  ProgressLine line;
  std::vector<EpisodeSummary> episodes;
  for (std::uint64_t k = 1; k <= plan.episodes && InterruptGuard::signal() == 0; ++k) {
    EpisodeSummary episode = fly_episode(k, plan, simulation, policy, log, line);
    const bool has_begun = episode.steps > 0 || InterruptGuard::signal() == 0;
    if (has_begun) episodes.push_back(std::move(episode));
  }
  return episodes;
}

}  // namespace skybody
