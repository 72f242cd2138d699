#include <charconv>

#include "core/base/system/printable.h"
#include "core/io/files/file.h"
#include "core/io/files/text.h"
#include "core/io/yaml/config_tree.h"

namespace skybody {
namespace {

constexpr std::size_t kLongestMark = 200;  // [bytes] of an override; each of its values has a copy

/// One step of a path: a key, or an index into a list.
struct PathStep {
  std::string key;
  int index = -1;

  std::string text() const { return index < 0 ? key : '[' + std::to_string(index) + ']'; }
};

/// Splits `a.b[2].c`; nullopt if the text is not a path.
std::optional<std::vector<PathStep>> split_path(const std::string& path) {
  std::vector<PathStep> steps;
  std::size_t i = 0;
  while (i < path.size()) {
    if (path[i] == '[') {
      int index = 0;
      const char* first = path.data() + i + 1;
      const auto result = std::from_chars(first, path.data() + path.size(), index);
      const std::size_t end = static_cast<std::size_t>(result.ptr - path.data());
      if (result.ec != std::errc() || index < 0 || end >= path.size() || path[end] != ']') {
        return std::nullopt;
      }
      if (steps.empty()) return std::nullopt;
      steps.push_back({"", index});
      i = end + 1;
      if (i < path.size() && path[i] != '.' && path[i] != '[') return std::nullopt;
      continue;
    }
    if (path[i] == '.') {
      if (steps.empty()) return std::nullopt;
      ++i;
    }
    const std::size_t end = std::min(path.find_first_of(".[", i), path.size());
    const std::string key = path.substr(i, end - i);
    if (key.empty()) return std::nullopt;
    steps.push_back({key, -1});
    i = end;
  }
  if (steps.empty()) return std::nullopt;
  return steps;
}

class Override {
 public:
  Override(const std::string& assignment, Diagnostics& diagnostics, InputBudget& budget)
      : mark_{shortened(kOverridePrefix + assignment, kLongestMark), 0, 0},
        diagnostics_(diagnostics),
        budget_(budget) {}

  bool apply(ConfigNode& root, const std::string& assignment) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos) {
      return fail("a path and a value are needed, as in `stepping.dt=0.002`");
    }
    const auto steps = split_path(assignment.substr(0, equals));
    if (!steps) {
      return fail("`" + assignment.substr(0, equals) +
                  "` is not a path; write keys and indices as in `robots[0].pose.position`");
    }
    if (steps->size() > InputBudget::kDeepest) {
      return fail("the path has " + std::to_string(steps->size()) + " steps; allowed: at most " +
                  std::to_string(InputBudget::kDeepest));
    }
    const auto value = parse_yaml(assignment.substr(equals + 1), mark_.file, diagnostics_, budget_);
    if (!value) return false;
    ConfigNode* node = &root;
    ConfigNode* owner = nullptr;
    std::string path;
    for (const PathStep& step : *steps) {
      owner = node;
      node = descend(*node, step, path);
      if (node == nullptr) return false;
      path += (path.empty() || step.index >= 0 ? "" : ".") + step.text();
    }
    if (value->is_null()) {
      remove(*owner, node);
    } else {
      *node = *value;
    }
    return true;
  }

 private:
  bool fail(const std::string& message) {
    diagnostics_.error(mark_, message);
    return false;
  }

  /// Removes a value from its map or list, like `~` in an including file.
  static void remove(ConfigNode& owner, const ConfigNode* value) {
    std::erase_if(owner.items, [&](const ConfigNode& item) { return &item == value; });
    std::erase_if(owner.entries, [&](const ConfigEntry& entry) { return &entry.value == value; });
  }

  ConfigNode* none(const std::string& message) {
    fail(message);
    return nullptr;
  }

  ConfigNode* descend(ConfigNode& node, const PathStep& step, const std::string& path) {
    if (node.is_sequence()) return in_list(node, step, path);
    if (node.is_scalar() || step.index >= 0) {
      const std::string place = path.empty() ? "the scenario" : "`" + path + "`";
      return none(place + " is " + node.describe() + "; it has no `" + step.text() + "`");
    }
    if (node.is_null()) {
      node.kind = ConfigNode::Kind::kMap;
      node.mark = mark_;
    }
    if (ConfigNode* existing = node.find(step.key)) return existing;
    if (!budget_.take_values(1, step.key.size() + 2 * mark_.file.size())) {
      return none(too_many_values());
    }
    ConfigNode added;
    added.mark = mark_;
    node.entries.push_back({step.key, mark_, added});
    return &node.entries.back().value;
  }

  ConfigNode* in_list(ConfigNode& list, const PathStep& step, const std::string& path) {
    const int count = static_cast<int>(list.items.size());
    if (step.index >= 0) {
      if (step.index < count) return &list.items[step.index];
      return none("`" + path + "` has " + std::to_string(count) +
                  (count == 1 ? " entry" : " entries") + "; there is no [" +
                  std::to_string(step.index) + "], indices start at 0");
    }
    return entry_called(list, step.key, path, mark_, diagnostics_);
  }

  SourceLocation mark_;
  Diagnostics& diagnostics_;
  InputBudget& budget_;
};

}  // namespace

bool apply_override(ConfigNode& root, const std::string& assignment, Diagnostics& diagnostics,
                    InputBudget& budget) {
  return Override(assignment, diagnostics, budget).apply(root, assignment);
}

bool apply_override(ConfigNode& root, const std::string& assignment, Diagnostics& diagnostics) {
  InputBudget budget;
  return apply_override(root, assignment, diagnostics, budget);
}

}  // namespace skybody
