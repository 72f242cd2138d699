// Checks of callers' arguments: indices, ranges, numbers of values. One message per mistake.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace skybody {

namespace detail {
[[noreturn]] void refuse_index(const char* noun, int index, int count);
[[noreturn]] void refuse_values(const char* noun, std::size_t given, std::size_t rows,
                                std::size_t width);
}  // namespace detail

/// @param noun  noun of the index, such as "environment"
/// @throws Error unless 0 <= index < count
inline void check_index(const char* noun, int index, int count) {
  if (index < 0 || index >= count) detail::refuse_index(noun, index, count);
}

/// Rejects an index that occurs twice in a list. @throws Error always
[[noreturn]] void refuse_twice(const char* noun, int index);

/// @throws Error unless 0 <= index < count for each index, and no index occurs twice
void check_indices(const char* noun, std::span<const int> indices, int count);

/// @param noun    name of the values, such as "actions"
/// @param width   values per row
/// @throws Error unless given == rows * width
inline void check_values(const char* noun, std::size_t given, std::size_t rows, int width) {
  const auto each = static_cast<std::size_t>(width);
  if (given != rows * each) detail::refuse_values(noun, given, rows, each);
}

/// @param remedy  how to correct the value
/// @throws Error unless low <= value <= high
void check_range(const char* noun, int value, int low, int high, const char* remedy);

/// @throws Error if steps < 0
void check_physics_steps(std::int64_t steps);

}  // namespace skybody
