#include "effects/wind_table/velocity_table.h"

#include <skybody/plugin.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace skybody {
namespace {

constexpr const char* kNames[VelocityTable::kColumns] = {"t", "x", "y", "z"};

[[noreturn]] void refuse(const std::string& place, const std::string& why) {
  throw std::runtime_error("`file`: " + place + ": " + why);
}

/// Reads the whole file. Only regular files are opened, so reading never blocks.
std::string text_of(const std::string& file) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(file, failed)) {
    refuse(file, "there is no such file; give a CSV file with the columns t, x, y, z");
  }
  const auto size = std::filesystem::file_size(file, failed);
  if (failed || size > VelocityTable::kMostBytes) {
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

/// Splits off the text before a separator, which may be missing.
std::string_view cut(std::string_view& rest, char separator) {
  const std::size_t end = std::min(rest.find(separator), rest.size());
  const std::string_view part = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return part;
}

/// Splits a line into the four cells.
void split(std::string_view line, const std::string& place,
           std::string_view (&cells)[VelocityTable::kColumns]) {
  int count = 1;
  for (const char c : line) count += c == ',' ? 1 : 0;
  if (count != VelocityTable::kColumns) {
    refuse(place, "the line has " + std::to_string(count) + (count == 1 ? " cell" : " cells") +
                      "; needed: the four of t, x, y, z");
  }
  for (std::string_view& cell : cells) cell = trimmed(cut(line, ','));
}

double number_of(std::string_view cell, int column, const std::string& place) {
  const std::string name = std::string("`") + kNames[column] + "` ";
  if (cell.empty()) refuse(place, name + "is missing; every row needs t, x, y, z");
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
    refuse(place, name + "is no finite number");
  }
  if (column > 0 && std::abs(value) > VelocityTable::kFastest) {
    refuse(place, name + "is " + to_text(value) + " m/s; allowed: -100 to 100 m/s");
  }
  return value;
}

/// Reads the lines of one file in order.
class Reader {
 public:
  void take(std::string_view line, const std::string& place) {
    std::string_view cells[VelocityTable::kColumns];
    split(line, place, cells);
    if (!has_header_) return take_header(cells, place);
    for (int c = 0; c < VelocityTable::kColumns; ++c) {
      table.values.push_back(number_of(cells[c], c, place));
    }
    const std::size_t last = table.rows() - 1;
    if (last > 0 && !(table.time(last) > table.time(last - 1))) {
      refuse(place, "the time " + to_text(table.time(last)) + " s does not come after " +
                        to_text(table.time(last - 1)) + " s of the row before; times must rise");
    }
  }

  VelocityTable table;

 private:
  void take_header(const std::string_view (&cells)[VelocityTable::kColumns],
                   const std::string& place) {
    for (int c = 0; c < VelocityTable::kColumns; ++c) {
      if (cells[c] != kNames[c]) refuse(place, "the first line must be t,x,y,z");
    }
    has_header_ = true;
  }

  bool has_header_ = false;
};

}  // namespace

bool VelocityTable::has_equal_steps() const {
  const double step = (end() - begin()) / static_cast<double>(rows() - 1);
  for (std::size_t row = 0; row < rows(); ++row) {
    const double place = begin() + static_cast<double>(row) * step;
    if (!(std::abs(time(row) - place) <= 1e-9 * step)) return false;
  }
  return true;
}

VelocityTable read_velocity_table(const std::string& file) {
  const std::string text = text_of(file);
  std::string_view rest = text;
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // written by spreadsheets
  if (rest.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
    rest.remove_prefix(kByteOrderMark.size());
  }
  Reader reader;
  for (int line = 1; !rest.empty(); ++line) {
    const std::string_view row = trimmed(cut(rest, '\n'));
    if (row.empty() || row.front() == '#') continue;
    reader.take(row, file + ":" + std::to_string(line));
  }
  const std::size_t rows = reader.table.rows();
  if (rows < 2) {
    refuse(file, "the file has " + std::to_string(rows) + (rows == 1 ? " row" : " rows") +
                     " of numbers; needed: two or more below the line t,x,y,z");
  }
  return std::move(reader.table);
}

}  // namespace skybody
