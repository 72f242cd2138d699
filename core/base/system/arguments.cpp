#include "core/base/system/arguments.h"

#include <string>
#include <vector>

#include "core/base/system/error.h"

namespace skybody {

void detail::refuse_index(const char* noun, int index, int count) {
  throw Error(std::string("there is no ") + noun + " " + std::to_string(index) +
              "; allowed: 0 ... " + std::to_string(count - 1));
}

void detail::refuse_values(const char* noun, std::size_t given, std::size_t rows,
                           std::size_t width) {
  throw Error(std::string(noun) + " has " + std::to_string(given) + " values; expected " +
              (rows == 1 ? "" : std::to_string(rows) + " x ") + std::to_string(width));
}

void refuse_twice(const char* noun, int index) {
  throw Error(std::string(noun) + " " + std::to_string(index) + " is there twice");
}

void check_indices(const char* noun, std::span<const int> indices, int count) {
  std::vector<bool> seen(static_cast<std::size_t>(count));
  for (const int index : indices) {
    check_index(noun, index, count);
    if (seen[static_cast<std::size_t>(index)]) refuse_twice(noun, index);
    seen[static_cast<std::size_t>(index)] = true;
  }
}

void check_range(const char* noun, int value, int low, int high, const char* remedy) {
  if (value >= low && value <= high) return;
  throw Error(std::string(noun) + " is " + std::to_string(value) +
              "; allowed: " + std::to_string(low) + " ... " + std::to_string(high) + "; " + remedy);
}

void check_physics_steps(std::int64_t steps) {
  if (steps >= 0) return;
  throw Error("physics_steps is " + std::to_string(steps) + "; it must be 0 or more");
}

}  // namespace skybody
