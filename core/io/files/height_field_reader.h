// Height fields of obstacles: a grid of heights in the scenario, or in a CSV file. Internal to
// core/io.
#pragma once

#include <memory>

#include "core/io/files/input_budget.h"
#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/diagnostics.h"
#include "core/model/robot_model.h"

namespace skybody {

/// Largest number of heights of a field: 2^20, which take 8 MiB.
inline constexpr std::size_t kMostHeights = 1u << 20;

/// Reads `height_field` of an obstacle into its shape. Returns false after errors.
/// @param node  the value of the key
bool read_height_field(const ConfigNode& node, InputBudget& budget, Diagnostics& diagnostics,
                       Shape& shape);

/// Parses the heights of a file: one line per row, in ascending order of y; one number per column,
/// in ascending order of x, separated by commas. Empty lines and lines that start with # are
/// skipped. Returns null and errors with the line for invalid files. Messages do not quote the
/// file, which may be any file of the system.
/// @param file  for messages
std::shared_ptr<const HeightField> parse_heights(const std::string& text, const std::string& file,
                                                 Diagnostics& diagnostics);

}  // namespace skybody
