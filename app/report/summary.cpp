#include "app/report/summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "app/report/flight_record.h"
#include "app/report/text_table.h"

namespace skybody {
namespace {

constexpr double kMillimetres = 1e3;
constexpr double kDegrees = 180.0 / std::numbers::pi;

/// Three digits after the decimal point; a value too small for these with its order of magnitude.
std::string small_number(double value) {
  if (value == 0.0 || !(std::abs(value) < 1e-3)) return fixed(value, 3);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.0e", value);
  return text.data();
}

std::vector<std::string> error_cells(const std::string& goal, const GoalError& error) {
  return {goal, small_number(kMillimetres * error.mean), small_number(kMillimetres * error.max),
          small_number(kDegrees * error.yaw)};
}

constexpr std::size_t kWidestEnd = 48;  ///< characters of a reason that fit in the table

/// An episode's end in the table: a long reason is cut, and printed in full below.
std::string short_end(const std::string& end) {
  if (end.size() <= kWidestEnd) return end;
  return end.substr(0, end.rfind(' ', kWidestEnd)) + " ...";
}

/// The full text of ends that the table cuts: "episodes 1, 3: fault: ...".
std::string whole_ends(const std::vector<EpisodeSummary>& episodes) {
  constexpr std::size_t kMostNamed = 8;
  std::map<std::string, std::vector<std::size_t>> cut;
  for (std::size_t k = 0; k < episodes.size(); ++k) {
    if (short_end(episodes[k].end) != episodes[k].end) cut[episodes[k].end].push_back(k + 1);
  }
  std::string text;
  for (const auto& [end, numbers] : cut) {
    text += numbers.size() == 1 ? "episode" : "episodes";
    for (std::size_t i = 0; i < std::min(numbers.size(), kMostNamed); ++i) {
      text += (i == 0 ? " " : ", ") + std::to_string(numbers[i]);
    }
    if (numbers.size() > kMostNamed) {
      text += " and " + std::to_string(numbers.size() - kMostNamed) + " more";
    }
    text += ": " + end + "\n";
  }
  return text;
}

/// Adds an episode's rows: leading cells in the first row, blanks in the others.
void add_rows(TextTable& table, const std::vector<std::string>& lead,
              const std::vector<std::string>& goals, const std::vector<GoalError>& errors) {
  if (goals.empty()) table.add(lead);
  for (std::size_t k = 0; k < goals.size(); ++k) {
    std::vector<std::string> row = k == 0 ? lead : std::vector<std::string>(lead.size());
    for (std::string& cell : error_cells(goals[k], errors[k])) row.push_back(std::move(cell));
    table.add(std::move(row));
  }
}

/// "2 truncated, 1 fault".
std::string count_ends(const std::vector<EpisodeSummary>& episodes) {
  std::map<std::string, int> counts;
  for (const EpisodeSummary& episode : episodes) ++counts[short_end(episode.end)];
  std::string text;
  for (const auto& [end, count] : counts) {
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + end;
  }
  return text;
}

/// Mean of the means and maximum of the maxima, over the episodes that have errors.
GoalError over_all(const std::vector<EpisodeSummary>& episodes, std::size_t goal) {
  GoalError sum;
  double count = 0.0;
  for (const EpisodeSummary& episode : episodes) {
    const GoalError& error = episode.goals[goal];
    if (std::isnan(error.mean)) continue;
    sum.mean += error.mean;
    sum.max = std::max(sum.max, error.max);
    sum.yaw += error.yaw;
    count += 1.0;
  }
  return {sum.mean / count, sum.max, sum.yaw / count};
}

void add_total(TextTable& table, const std::vector<std::string>& goals,
               const std::vector<EpisodeSummary>& episodes) {
  EpisodeSummary total;
  for (const EpisodeSummary& episode : episodes) {
    total.steps += episode.steps;
    total.time += episode.time;
    total.total_reward += episode.total_reward / static_cast<double>(episodes.size());
  }
  for (std::size_t k = 0; k < goals.size(); ++k) total.goals.push_back(over_all(episodes, k));
  table.add_rule();
  add_rows(table,
           {"all", std::to_string(total.steps), fixed(total.time, 3),
            fixed(total.total_reward, 4) + " mean", count_ends(episodes)},
           goals, total.goals);
}

/// "success: 97 of 100 episodes" for a task with that info; read at the end of each episode.
std::string success_line(const CompiledScenario& compiled,
                         const std::vector<EpisodeSummary>& episodes) {
  std::size_t k = 0;
  for (const Channel& channel : compiled.info_channels()) {
    if (channel.name != kSuccessInfo) {
      k += static_cast<std::size_t>(channel.count);
      continue;
    }
    const auto succeeded = std::count_if(episodes.begin(), episodes.end(), [&](const auto& e) {
      return k < e.infos.size() && e.infos[k].last > 0.5;
    });
    return "success: " + std::to_string(succeeded) + " of " + std::to_string(episodes.size()) +
           " episodes\n";
  }
  return "";
}

/// "clipped: 12 of 8000 action values lay beyond [-1, 1]", or empty.
std::string clipped_line(const CompiledScenario& compiled,
                         const std::vector<EpisodeSummary>& episodes) {
  std::uint64_t clipped = 0, all = 0;
  for (const EpisodeSummary& episode : episodes) {
    clipped += episode.clipped;
    all += episode.steps * static_cast<std::uint64_t>(compiled.action_size());
  }
  if (clipped == 0) return "";
  return "clipped: " + std::to_string(clipped) + " of " + std::to_string(all) +
         " action values lay beyond [-1, 1]\n";
}

}  // namespace

std::string summary_table(const CompiledScenario& compiled,
                          const std::vector<EpisodeSummary>& episodes) {
  std::vector<std::string> goals;
  for (const Goal& goal : compiled.task().task.goals) {
    goals.push_back(body_name(compiled, goal.body));
  }
  std::vector<std::string> heading = {"episode", "steps", "time [s]", "return", "end"};
  if (!goals.empty()) {
    heading.insert(heading.end(), {"goal of", "error [mm]", "max [mm]", "yaw error [deg]"});
  }
  TextTable table(std::move(heading));
  for (std::size_t k = 0; k < episodes.size(); ++k) {
    const EpisodeSummary& episode = episodes[k];
    add_rows(table,
             {std::to_string(k + 1), std::to_string(episode.steps), fixed(episode.time, 3),
              fixed(episode.total_reward, 4), short_end(episode.end)},
             goals, episode.goals);
  }
  if (!episodes.empty()) add_total(table, goals, episodes);
  return table.to_string() + success_line(compiled, episodes) + clipped_line(compiled, episodes) +
         (goals.empty() ? "" : "errors: mean and largest over the last second\n") +
         whole_ends(episodes);
}

}  // namespace skybody
