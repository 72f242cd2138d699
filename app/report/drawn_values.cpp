#include "app/report/drawn_values.h"

#include <algorithm>
#include <utility>

#include "app/report/text_table.h"

namespace skybody {
namespace {

constexpr int kMostRows = 24;

/// Smallest and largest value of a parameter in the episodes, at resets and later.
std::pair<double, double> range_of(const std::vector<EpisodeSummary>& episodes, std::size_t param) {
  double least = episodes.front().params.front()[param], greatest = least;
  for (const EpisodeSummary& episode : episodes) {
    for (const std::vector<double>& drawn : episode.params) {
      least = std::min(least, drawn[param]);
      greatest = std::max(greatest, drawn[param]);
    }
  }
  return {least, greatest};
}

}  // namespace

std::string drawn_values(const CompiledScenario& compiled,
                         const std::vector<EpisodeSummary>& episodes) {
  TextTable table({"drawn value", "unit", "nominal", "least", "greatest"});
  const std::vector<EnvParam>& params = compiled.layout().param_info;
  if (episodes.empty()) return "";
  int count = 0;
  for (std::size_t k = 0; k < params.size(); ++k) {
    const auto [least, greatest] = range_of(episodes, k);
    if (least == params[k].nominal && greatest == params[k].nominal) continue;
    if (++count > kMostRows) continue;
    table.add({params[k].path, params[k].unit, short_number(params[k].nominal), short_number(least),
               short_number(greatest)});
  }
  if (count == 0) return "";
  std::string text = table.to_string();
  if (count > kMostRows)
    text += "and " + std::to_string(count - kMostRows) + " more, see the log\n";
  return text;
}

}  // namespace skybody
