#include "plugins/reference/path_table.h"

#include <algorithm>
#include <vector>

#include "core/plugin_abi/text.h"
#include "plugins/reference/timed_table.h"

namespace skybody::reference {
namespace {

constexpr double kFarthest = 1e5;   // [m]
constexpr double kLongestGap = 10;  // times the median interval
constexpr std::size_t kPlaces = 4;  // columns of every file

/// Refuses gaps, across which a smooth curve would overshoot.
void check_gaps(const TimedTable& table) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < table.rows(); ++i) steps.push_back(table.time(i) - table.time(i - 1));
  std::vector<double> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] <= kLongestGap * *middle) continue;
    refuse_file(table.places[i + 1],
                "a gap of " + to_text(steps[i]) + " s, where the median interval is " +
                    to_text(*middle) +
                    " s; allowed: ten times as long. Fill in the rows that lack");
  }
}

}  // namespace

PathTable read_path_table(const std::string& file) {
  const TimedTable table =
      read_timed_table(file, {{"t", "x", "y", "z", "yaw"}, kPlaces, kFarthest});
  check_gaps(table);
  const bool has_yaw = table.columns > kPlaces;
  std::vector<double> times, values;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    times.push_back(table.time(row));
    for (std::size_t c = 1; c < kPlaces; ++c) values.push_back(table.at(row, c));
    values.push_back(has_yaw ? table.at(row, kPlaces) : 0.0);
  }
  return {Spline(times, values, SplineEnds::kFree), has_yaw};
}

}  // namespace skybody::reference
