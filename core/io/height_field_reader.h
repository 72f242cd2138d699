// Height fields of obstacles: a grid of heights in the scenario, or in a CSV file. Internal to
// core/io.
#pragma once

#include <memory>

#include "core/io/config_tree.h"
#include "core/io/diagnostics.h"
#include "core/io/input_budget.h"
#include "core/model/robot_model.h"

namespace skybody {

/// Most heights of a field: a mebi of them takes 8 MiB.
inline constexpr std::size_t kMostHeights = 1u << 20;

/// Reads `height_field` of an obstacle into its shape; false, and errors, if anything is wrong.
/// @param node  the value of the key
bool read_height_field(const ConfigNode& node, InputBudget& budget, Diagnostics& diagnostics,
                       Shape& shape);

/// Heights of a file: a line for each row, in the order of rising y, with a number for each column,
/// in the order of rising x, and commas between them. Lines that are empty or start with # do not
/// count. Nothing, and errors with the line, if anything is wrong; what the file says is not
/// quoted, since it may be any file of the system.
/// @param file  for messages
std::shared_ptr<const HeightField> parse_heights(const std::string& text, const std::string& file,
                                                 Diagnostics& diagnostics);

}  // namespace skybody
