#include "app/drawn_values.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "app/text_table.h"

namespace skybody {
namespace {

constexpr int kMostRows = 24;

std::string short_number(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

/// Least and greatest value of a parameter in the episodes.
std::pair<double, double> range_of(const std::vector<EpisodeSummary>& episodes, std::size_t param) {
  double least = episodes.front().params[param], greatest = least;
  for (const EpisodeSummary& episode : episodes) {
    least = std::min(least, episode.params[param]);
    greatest = std::max(greatest, episode.params[param]);
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
