#include "plugins/reference/timed_table.h"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>

#include "core/base/system/csv.h"
#include "plugins/api/refuse.h"

namespace skybody::reference {
namespace {

constexpr std::uintmax_t kMostBytes = 16u << 20;

/// The whole content of a file. Only regular files are opened, so that reading never blocks.
std::string text_of(const std::string& file, const std::string& names) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(file, failed)) {
    refuse_file(file, "there is no such file; give a CSV file with the columns " + names);
  }
  const auto size = std::filesystem::file_size(file, failed);
  if (failed || size > kMostBytes) {
    refuse_file(file, "the file is larger than 16 MiB, which is the most that is allowed; cut it");
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream) refuse_file(file, "the file cannot be read");
  return text;
}

/// Reads the lines of one file in order.
class Reader {
 public:
  explicit Reader(const TimedColumns& columns) : columns_(columns) {}

  void take(std::string_view line, const std::string& place) {
    const std::vector<std::string_view> cells = csv::cells_of(line);
    if (table.columns == 0) return take_header(cells, place);
    if (cells.size() != table.columns) {
      refuse_file(place, "the line has " + std::to_string(cells.size()) +
                             (cells.size() == 1 ? " cell" : " cells") + "; needed: the " +
                             std::to_string(table.columns) + " of " + names(table.columns, ", "));
    }
    for (std::size_t c = 0; c < cells.size(); ++c) {
      table.values.push_back(number_of(cells[c], c, place));
    }
    table.places.push_back(place);
    const std::size_t last = table.rows() - 1;
    if (last > 0 && !(table.time(last) > table.time(last - 1))) {
      refuse_file(place, "the time " + to_text(table.time(last)) + " s does not come after " +
                             to_text(table.time(last - 1)) +
                             " s of the row before; times must rise");
    }
  }

  std::string names(std::size_t count, const char* separator) const {
    std::string text;
    for (std::size_t c = 0; c < count; ++c) text += (c > 0 ? separator : "") + name(c);
    return text;
  }

  TimedTable table;

 private:
  std::string name(std::size_t column) const { return columns_.names[column]; }

  void take_header(const std::vector<std::string_view>& cells, const std::string& place) {
    for (std::size_t count = columns_.least; count <= columns_.names.size(); ++count) {
      if (std::vector<std::string_view>(
              columns_.names.begin(), columns_.names.begin() + static_cast<long>(count)) == cells) {
        table.columns = count;
        return;
      }
    }
    std::string allowed = names(columns_.least, ",");
    for (std::size_t count = columns_.least + 1; count <= columns_.names.size(); ++count) {
      allowed += " or " + names(count, ",");
    }
    refuse_file(place, "the first line must be " + allowed);
  }

  double number_of(std::string_view cell, std::size_t column, const std::string& place) const {
    const std::string which = "`" + name(column) + "` ";
    if (cell.empty()) {
      refuse_file(place, which + "is missing; every row needs " + names(table.columns, ", "));
    }
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
      refuse_file(place, which + "is no finite number");
    }
    if (column > 0 && std::abs(value) > columns_.greatest) {
      const std::string most = to_text(columns_.greatest);
      refuse_file(place, which + "is " + to_text(value) + columns_.unit + "; allowed: -" + most +
                             " to " + most + columns_.unit);
    }
    return value;
  }

  const TimedColumns& columns_;
};

}  // namespace

void refuse_file(const std::string& place, const std::string& why) {
  refuse("`file`: ", place, ": ", why);
}

TimedTable read_timed_table(const std::string& file, const TimedColumns& columns) {
  Reader reader(columns);
  const std::string text = text_of(file, reader.names(columns.least, ", "));
  csv::each_row(text, [&](std::string_view row, int line) {
    reader.take(row, file + ":" + std::to_string(line));
    return true;
  });
  const std::size_t rows = reader.table.rows();
  if (rows < 2) {
    refuse_file(file, "the file has " + std::to_string(rows) + (rows == 1 ? " row" : " rows") +
                          " of numbers; needed: two or more below the line " +
                          reader.names(columns.least, ","));
  }
  return std::move(reader.table);
}

}  // namespace skybody::reference
