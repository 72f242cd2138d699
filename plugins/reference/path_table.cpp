#include "plugins/reference/path_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "core/plugin_abi/text.h"

namespace skybody::reference {
namespace {

constexpr std::uintmax_t kMostBytes = 16u << 20;
constexpr double kFarthest = 1e5;   // [m]
constexpr double kLongestGap = 10;  // times the median interval

constexpr const char* kNames[] = {"t", "x", "y", "z", "yaw"};
constexpr std::size_t kLeastColumns = 4, kMostColumns = 5;

[[noreturn]] void refuse(const std::string& place, const std::string& why) {
  throw std::runtime_error("`file`: " + place + ": " + why);
}

/// The whole content of a file. Only regular files are opened, so that reading never blocks.
std::string text_of(const std::string& file) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(file, failed)) {
    refuse(file, "there is no such file; give a CSV file with the columns t, x, y, z");
  }
  const auto size = std::filesystem::file_size(file, failed);
  if (failed || size > kMostBytes) {
    refuse(file, "the file is larger than 16 MiB, which is the most that is allowed; cut it");
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream) refuse(file, "the file cannot be read");
  return text;
}

std::string_view trimmed(std::string_view text) {
  const char* const blank = " \t\r";
  const std::size_t first = text.find_first_not_of(blank);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

/// Cuts off the text before a separator; without a separator, the whole text.
std::string_view cut(std::string_view& rest, char separator) {
  const std::size_t end = std::min(rest.find(separator), rest.size());
  const std::string_view part = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return part;
}

std::vector<std::string_view> cells_of(std::string_view line) {
  const auto count = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
  std::vector<std::string_view> cells(count);
  for (std::string_view& cell : cells) cell = trimmed(cut(line, ','));
  return cells;
}

double number_of(std::string_view cell, std::size_t column, const std::string& place) {
  const std::string name = std::string("`") + kNames[column] + "` ";
  if (cell.empty()) refuse(place, name + "is missing; every row needs a number in every column");
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
    refuse(place, name + "is no finite number");
  }
  if (column > 0 && std::abs(value) > kFarthest) {
    refuse(place, name + "is " + to_text(value) + "; allowed: -100000 to 100000");
  }
  return value;
}

/// Parses the lines of one file in order.
class Reader {
 public:
  void take(std::string_view line, const std::string& place) {
    const std::vector<std::string_view> cells = cells_of(line);
    if (columns_ == 0) return take_header(cells, place);
    if (cells.size() != columns_) {
      refuse(place, "the line has " + std::to_string(cells.size()) +
                        " cells; needed: " + std::to_string(columns_) + ", as the first line has");
    }
    for (std::size_t c = 0; c < columns_; ++c) {
      (c == 0 ? times : values).push_back(number_of(cells[c], c, place));
    }
    if (columns_ == kLeastColumns) values.push_back(0.0);
    places_.push_back(place);
    const std::size_t n = times.size();
    if (n > 1 && !(times[n - 1] > times[n - 2])) {
      refuse(place, "the time " + to_text(times[n - 1]) + " s does not come after " +
                        to_text(times[n - 2]) + " s of the row before; times must rise");
    }
  }

  /// Refuses gaps, across which a smooth curve would overshoot.
  void check(const std::string& file) const {
    if (times.size() < 2) {
      refuse(file, "the file has " + std::to_string(times.size()) +
                       (times.size() == 1 ? " row" : " rows") +
                       " of numbers; needed: two or more below the line t,x,y,z");
    }
    std::vector<double> steps;
    for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
    std::vector<double> sorted = steps;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (steps[i] <= kLongestGap * *middle) continue;
      refuse(places_[i + 1], "a gap of " + to_text(steps[i]) + " s, where the median interval is " +
                                 to_text(*middle) +
                                 " s; allowed: ten times as long. Fill in the rows that lack");
    }
  }

  bool has_yaw() const { return columns_ == kMostColumns; }

  std::vector<double> times, values;  ///< values: four per row

 private:
  void take_header(const std::vector<std::string_view>& cells, const std::string& place) {
    const bool fits = cells.size() == kLeastColumns || cells.size() == kMostColumns;
    if (!fits || !std::equal(cells.begin(), cells.end(), kNames)) {
      refuse(place, "the first line must be t,x,y,z or t,x,y,z,yaw");
    }
    columns_ = cells.size();
  }

  std::size_t columns_ = 0;
  std::vector<std::string> places_;
};

}  // namespace

PathTable read_path_table(const std::string& file) {
  const std::string text = text_of(file);
  std::string_view rest = text;
  Reader reader;
  for (int line = 1; !rest.empty(); ++line) {
    const std::string_view row = trimmed(cut(rest, '\n'));
    if (row.empty() || row.front() == '#') continue;
    reader.take(row, file + ":" + std::to_string(line));
  }
  reader.check(file);
  return {Spline(reader.times, reader.values, SplineEnds::kFree), reader.has_yaw()};
}

}  // namespace skybody::reference
