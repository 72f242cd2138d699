#include "core/io/files/height_field_reader.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/base/system/csv.h"
#include "core/io/files/file.h"
#include "core/io/files/text.h"
#include "core/io/yaml/field.h"
#include "core/io/yaml/plausibility_limits.h"
#include "core/io/yaml/ranges.h"
#include "core/io/yaml/scenario_fields.h"

namespace skybody {
namespace {

constexpr std::string_view kExtension = ".csv";

std::string too_many_heights() {
  return "more than " + std::to_string(kMostHeights) +
         " heights, which is the most that is allowed";
}

/// Reads one file of heights.
class HeightsReader {
 public:
  HeightsReader(const std::string& file, Diagnostics& diagnostics)
      : file_(file), diagnostics_(diagnostics) {}

  std::shared_ptr<const HeightField> read(std::string_view text) {
    const auto take = [this](std::string_view row, int line) { return take_row(row, line); };
    if (!csv::each_row(text, take)) return nullptr;
    if (rows_ < 2 || columns_ < 2) {
      diagnostics_.error({file_, 0, 0}, "the file has " + std::to_string(rows_) + " rows of " +
                                            std::to_string(columns_) +
                                            " heights; needed: two or more rows of two or more");
      return nullptr;
    }
    return std::make_shared<HeightField>(columns_, rows_, std::move(heights_));
  }

 private:
  bool take_row(std::string_view row, int line) {
    int columns = 0;
    for (const std::string_view cell : csv::cells_of(row)) {
      if (!take_height(cell, ++columns, line)) return false;
    }
    if (rows_++ == 0) {
      columns_ = columns;
      first_line_ = line;
    }
    if (columns == columns_) return true;
    return refuse(line, "the row has " + std::to_string(columns) + " heights, that of line " +
                            std::to_string(first_line_) + " has " + std::to_string(columns_) +
                            "; all rows must have as many");
  }

  bool take_height(std::string_view text, int column, int line) {
    const std::optional<double> height = parse_number(std::string(text));
    const std::string which = "height " + std::to_string(column) + " of the row ";
    if (!height) return refuse(line, which + "is no number; allowed: " + kPlaceRange.text());
    if (!kPlaceRange.has(*height)) {
      return refuse(line,
                    which + "is " + format_number(*height) + "; allowed: " + kPlaceRange.text());
    }
    if (heights_.size() == kMostHeights) return refuse(line, "the file has " + too_many_heights());
    heights_.push_back(*height);
    return true;
  }

  bool refuse(int line, const std::string& why) {
    diagnostics_.error({file_, line, 0}, why);
    return false;
  }

  const std::string& file_;
  Diagnostics& diagnostics_;
  std::vector<double> heights_;
  int columns_ = 0, rows_ = 0, first_line_ = 0;
};

std::shared_ptr<const HeightField> heights_of_file(const MapReader& reader, InputBudget& budget,
                                                   Diagnostics& diagnostics) {
  const std::string written = reader.text("file");
  const SourceLocation mark = reader.mark("file");
  const bool is_csv =
      written.size() > kExtension.size() &&
      written.compare(written.size() - kExtension.size(), written.npos, kExtension) == 0;
  if (!is_csv) {
    diagnostics.error(mark, "`file` is `" + written +
                                "`; allowed: a file of heights whose name "
                                "ends in .csv");
    return nullptr;
  }
  const std::string file = resolve_path(written, mark);
  const std::optional<std::string> text = read_file(file, mark, diagnostics);
  if (!text) return nullptr;
  if (!budget.take_file(text->size())) {
    diagnostics.error(mark, too_much_text());
    return nullptr;
  }
  return parse_heights(*text, file, diagnostics);
}

std::shared_ptr<const HeightField> heights_of_yaml(const MapReader& reader,
                                                   Diagnostics& diagnostics) {
  const int errors_before = diagnostics.error_count();
  std::vector<double> heights = reader.numbers("heights");
  const int columns = reader.integer("columns");
  if (diagnostics.error_count() > errors_before) return nullptr;
  const auto count = static_cast<int>(heights.size());
  if (reader.node("columns") == nullptr || count % columns != 0 || count / columns < 2) {
    diagnostics.error(
        reader.mark("heights"),
        "`heights` has " + std::to_string(count) + " numbers" +
            (reader.node("columns") == nullptr ? ", but `columns` is missing"
                                               : ", but `columns` is " + std::to_string(columns)) +
            "; needed: two or more rows of `columns` numbers");
    return nullptr;
  }
  return std::make_shared<HeightField>(columns, count / columns, std::move(heights));
}

}  // namespace

std::shared_ptr<const HeightField> parse_heights(const std::string& text, const std::string& file,
                                                 Diagnostics& diagnostics) {
  return HeightsReader(file, diagnostics).read(text);
}

bool read_height_field(const ConfigNode& node, InputBudget& budget, Diagnostics& diagnostics,
                       Shape& shape) {
  const MapReader reader(&node, height_field_fields(), node.mark, diagnostics);
  if (!node.is_map()) return false;
  const bool has_file = reader.node("file") != nullptr;
  if (has_file == (reader.node("heights") != nullptr)) {
    diagnostics.error(node.mark, std::string("`height_field` has ") +
                                     (has_file ? "`file` and `heights`" : "no heights") +
                                     "; needed: one of `file` and `heights`");
    return false;
  }
  shape.type = ShapeType::kHeightField;
  const std::vector<double> size = reader.numbers("size");
  shape.size = {size[0], size[1], 0.0};
  shape.heights = has_file ? heights_of_file(reader, budget, diagnostics)
                           : heights_of_yaml(reader, diagnostics);
  if (shape.heights == nullptr) return false;
  const std::vector<double>& heights = shape.heights->heights();
  const auto is_higher = [](double a, double b) { return std::fabs(a) < std::fabs(b); };
  const double farthest = *std::max_element(heights.begin(), heights.end(), is_higher);
  warn_if_implausible(PlausibilityLimit::kHeight, farthest, "the height farthest from 0", {},
                      node.mark, diagnostics);
  return true;
}

}  // namespace skybody
