#include "app/report/reported_values.h"

#include <cmath>
#include <limits>

#include "app/report/text_table.h"

namespace skybody {
namespace {

constexpr std::size_t kMostRows = 24;

/// Over the episodes: minimum, maximum, and the mean of the last values. Times that never came are
/// left out; NaN: none came.
InfoRange range_over(const std::vector<EpisodeSummary>& episodes, std::size_t value) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  InfoRange all{nan, nan, 0.0};
  double count = 0.0;
  for (const EpisodeSummary& episode : episodes) {
    if (episode.infos.empty()) continue;
    const InfoRange& range = episode.infos[value];
    all.least = std::fmin(all.least, range.least);
    all.greatest = std::fmax(all.greatest, range.greatest);
    if (std::isnan(range.last)) continue;
    all.last += range.last;
    count += 1.0;
  }
  all.last /= count;
  return all;
}

std::string cell(const Channel& channel, double value) {
  return std::isnan(value) && channel.unit == "s" ? "never" : short_number(value);
}

bool has_steps(const std::vector<EpisodeSummary>& episodes) {
  for (const EpisodeSummary& episode : episodes) {
    if (!episode.infos.empty()) return true;
  }
  return false;
}

}  // namespace

std::string reported_values(const CompiledScenario& compiled,
                            const std::vector<EpisodeSummary>& episodes) {
  if (!has_steps(episodes)) return "";
  TextTable table({"reported value", "unit", "least", "greatest", "at the end"});
  std::size_t value = 0;
  for (const Channel& channel : compiled.info_channels()) {
    for (int k = 0; k < channel.count; ++k, ++value) {
      if (value >= kMostRows) continue;
      const std::string index = channel.count == 1 ? "" : "[" + std::to_string(k) + "]";
      const InfoRange range = range_over(episodes, value);
      table.add({channel.name + index, channel.unit, cell(channel, range.least),
                 cell(channel, range.greatest), cell(channel, range.last)});
    }
  }
  std::string text = table.to_string();
  if (value > kMostRows)
    text += "and " + std::to_string(value - kMostRows) + " more, see the log\n";
  return text + (episodes.size() > 1 ? "at the end: mean over the episodes; times: mean over those "
                                       "in which they occurred\n"
                                     : "");
}

}  // namespace skybody
