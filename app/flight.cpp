#include "app/flight.h"

#include "app/flight_record.h"
#include "app/interrupt.h"
#include "app/progress_line.h"
#include "app/text_table.h"

namespace skybody {
namespace {

/// Why the episode is over; empty: it goes on.
std::string end_of(const FlightPlan& plan, const Simulation& simulation) {
  if (simulation.fault())
    return "fault: " + simulation.compiled().fault_reason(simulation.status());
  if (simulation.terminated()) return "terminated";
  if (simulation.truncated()) return "truncated";
  if (InterruptGuard::signal() != 0) return "interrupted";
  if (simulation.steps() >= plan.most_steps) return "stopped";
  return "";
}

std::string progress(std::uint64_t episode, const FlightPlan& plan, const Simulation& simulation,
                     const EpisodeSummary& summary) {
  const std::uint64_t percent = 100 * simulation.steps() / plan.most_steps;
  return "episode " + std::to_string(episode) + "/" + std::to_string(plan.episodes) + "  " +
         std::to_string(percent) + " %  step " + std::to_string(simulation.steps()) + "  " +
         fixed(simulation.time(), 1) + " s  return " + fixed(summary.total_reward, 3);
}

EpisodeSummary fly_episode(std::uint64_t number, const FlightPlan& plan, Simulation& simulation,
                           Policy& policy, FlightLog& log, ProgressLine& line) {
  EpisodeSummary summary;
  ErrorWindow window(simulation.compiled());
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  simulation.reset();
  summary.params = simulation.params();
  log.begin_episode(summary.params);
  record(simulation, false, log);
  log.event("reset");
  for (summary.end = end_of(plan, simulation); summary.end.empty();
       summary.end = end_of(plan, simulation)) {
    policy.act(simulation, action);
    const std::uint64_t before = simulation.step_counts().near;
    simulation.step(action);
    record(simulation, simulation.step_counts().near > before, log);
    window.add(simulation);
    summary.total_reward += static_cast<double>(simulation.reward());
    if (line.is_due()) line.show(progress(number, plan, simulation, summary));
  }
  log.event(summary.end);
  summary.steps = simulation.steps();
  summary.time = simulation.time();
  summary.goals = window.errors();
  return summary;
}

}  // namespace

FlightResult fly(const FlightPlan& plan, Simulation& simulation, Policy& policy, FlightLog& log) {
  const InterruptGuard guard;
  ProgressLine line;
  FlightResult result;
  for (std::uint64_t k = 1; k <= plan.episodes && InterruptGuard::signal() == 0; ++k) {
    result.episodes.push_back(fly_episode(k, plan, simulation, policy, log, line));
  }
  result.signal = InterruptGuard::signal();
  return result;
}

}  // namespace skybody
