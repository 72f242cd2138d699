// Checks of what callers give: indices, ranges, numbers of values. Each mistake has one wording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace skybody {

namespace detail {
[[noreturn]] void refuse_index(const char* what, int index, int count);
[[noreturn]] void refuse_values(const char* what, std::size_t given, std::size_t rows,
                                std::size_t width);
}  // namespace detail

/// @param what  such as "environment"
/// @throws Error unless 0 <= index < count
inline void check_index(const char* what, int index, int count) {
  if (index < 0 || index >= count) detail::refuse_index(what, index, count);
}

/// For an index that a list has a second time. @throws Error
[[noreturn]] void refuse_twice(const char* what, int index);

/// @throws Error unless each is such an index, and none is there twice
void check_indices(const char* what, std::span<const int> indices, int count);

/// @param what    such as "actions"
/// @param width   values of a row
/// @throws Error unless there are `rows` rows
inline void check_values(const char* what, std::size_t given, std::size_t rows, int width) {
  const auto each = static_cast<std::size_t>(width);
  if (given != rows * each) detail::refuse_values(what, given, rows, each);
}

/// @param remedy  what to give instead
/// @throws Error unless low <= value <= high
void check_range(const char* what, int value, int low, int high, const char* remedy);

/// @throws Error if there are fewer than none
void check_physics_steps(std::int64_t steps);

}  // namespace skybody
