// Patterns for the paths of randomizable values.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace skybody::plugin_detail {

/// Whether `path` matches `pattern`. `[*]` stands for any index, `*` elsewhere for any part of a
/// name.
inline bool matches(const std::string& pattern, const std::string& path) {
  std::size_t i = 0, j = 0;
  while (i < pattern.size() && j < path.size()) {
    if (pattern.compare(i, 3, "[*]") == 0 && path[j] == '[') {
      i += 3;
      j = path.find(']', j) + 1;
    } else if (pattern[i] == '*') {
      const std::size_t end = std::min(path.find_first_of(".[", j), path.size());
      for (std::size_t from = j; from <= end; ++from) {
        if (matches(pattern.substr(i + 1), path.substr(from))) return true;
      }
      return false;
    } else if (pattern[i++] != path[j++]) {
      return false;
    }
  }
  if (i + 1 == pattern.size() && pattern[i] == '*') ++i;  // `*` may match nothing
  if (i == pattern.size() && j < path.size())
    return path[j] == '[';  // the pattern names a whole vector
  return i == pattern.size() && j == path.size();
}

/// Expands a path: `robot.` and `controllers.` stand for those of every robot.
template <class Names>
std::vector<std::string> patterns_of(const std::string& path, const Names& robots) {
  std::vector<std::string> patterns{path};
  const bool is_of_robots = path.rfind("robot.", 0) == 0;
  if (!is_of_robots && path.rfind("controllers.", 0) != 0) return patterns;
  for (const auto& robot : robots) {
    patterns.push_back("robots." + std::string(robot) + "." + path.substr(is_of_robots ? 6 : 0));
  }
  return patterns;
}

/// Whether one of the patterns matches a value's path or its alias, which may be empty.
inline bool any_matches(const std::vector<std::string>& patterns, const std::string& path,
                        const std::string& alias) {
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    return matches(pattern, path) || (!alias.empty() && matches(pattern, alias));
  });
}

inline constexpr const char* kNoSuchParam = "; `skybody check --parameters` lists what is";

}  // namespace skybody::plugin_detail
