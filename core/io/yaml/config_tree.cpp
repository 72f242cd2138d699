#include "core/io/yaml/config_tree.h"

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "core/base/system/printable.h"
#include "core/io/files/text.h"

namespace skybody {
namespace {

constexpr std::size_t kLongestText = 100;  // [bytes] of a text in a message

}  // namespace

const ConfigNode* ConfigNode::find(const std::string& key) const {
  for (const ConfigEntry& entry : entries) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

ConfigNode* ConfigNode::find(const std::string& key) {
  for (ConfigEntry& entry : entries) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

std::vector<std::string> ConfigNode::keys() const {
  std::vector<std::string> names;
  for (const ConfigEntry& entry : entries) names.push_back(entry.key);
  return names;
}

std::string ConfigNode::describe() const {
  switch (kind) {
    case Kind::kNull:
      return "empty";
    case Kind::kSequence:
      return "a list";
    case Kind::kMap:
      return "a map";
    case Kind::kScalar:
      break;
  }
  if (parse_number(scalar)) return quoted ? "a text, \"" + scalar + '"' : "the number " + scalar;
  return "the text `" + shortened(printable(scalar), kLongestText) + "`";
}

ConfigCost cost_of(const ConfigNode& node) {
  ConfigCost cost{1, node.scalar.size() + node.mark.file.size(), 0};
  const auto add = [&](const ConfigNode& inner) {
    const ConfigCost more = cost_of(inner);
    cost.values += more.values;
    cost.bytes += more.bytes;
    cost.depth = std::max(cost.depth, more.depth + 1);
  };
  for (const ConfigNode& item : node.items) add(item);
  for (const ConfigEntry& entry : node.entries) {
    cost.bytes += entry.key.size() + entry.key_mark.file.size();
    add(entry.value);
  }
  return cost;
}

std::string too_many_values() {
  return "the YAML of this scenario holds more than " + std::to_string(InputBudget::kMostValues) +
         " values or " + std::to_string(InputBudget::kMostText >> 20) +
         " MiB of text, counted with what aliases and includes repeat; leave some out";
}

const std::string& name_of(const ConfigNode& item) {
  static const std::string none;
  for (const char* key : {"name", "plugin"}) {
    const ConfigNode* name = item.find(key);
    if (name != nullptr && name->is_scalar()) return name->scalar;
  }
  return none;
}

ConfigNode* entry_called(ConfigNode& list, const std::string& name, const std::string& path,
                         const SourceLocation& mark, Diagnostics& diagnostics,
                         const std::string& advice) {
  ConfigNode* found = nullptr;
  for (ConfigNode& item : list.items) {
    if (name.empty() || name_of(item) != name) continue;
    if (found != nullptr) {
      diagnostics.error(mark, "`" + path + "` has several entries called `" + name +
                                  "`; use an index such as [0]");
      return nullptr;
    }
    found = &item;
  }
  if (found == nullptr) {
    std::vector<std::string> names;
    for (const ConfigNode& item : list.items) {
      if (!name_of(item).empty()) names.push_back(name_of(item));
    }
    diagnostics.error(mark, "`" + path + "` has no entry called `" + name + "`" +
                                suggestion(name, names, "entries") + advice);
  }
  return found;
}

namespace {

bool has_names(const ConfigNode& list) {
  return list.is_sequence() && std::any_of(list.items.begin(), list.items.end(),
                                           [](const ConfigNode& i) { return !name_of(i).empty(); });
}

/// Patches entries of a list by name. Indexes the names once, since both lists may be long; reports
/// missing and ambiguous names through entry_called().
bool patch_list(ConfigNode& list, const ConfigNode& over, Diagnostics& diagnostics,
                const std::string& path) {
  std::unordered_map<std::string, int> count;
  std::unordered_map<std::string, ConfigNode*> places;
  for (ConfigNode& item : list.items) {
    ++count[name_of(item)];
    places[name_of(item)] = &item;
  }
  bool good = true;
  std::unordered_set<std::string> removed;
  for (const ConfigEntry& entry : over.entries) {
    const bool is_clear = !entry.key.empty() && count[entry.key] == 1;
    ConfigNode* item = is_clear ? places[entry.key]
                                : entry_called(list, entry.key, path, entry.key_mark, diagnostics,
                                               " (a map changes existing entries; to add one, "
                                               "write the whole list)");
    if (item != nullptr && entry.value.is_null()) {
      removed.insert(entry.key);
      continue;
    }
    good = item != nullptr &&
           merge_config(*item, entry.value, diagnostics, path + "." + entry.key) && good;
  }
  if (!removed.empty()) {
    std::erase_if(list.items, [&](const ConfigNode& i) { return removed.count(name_of(i)) > 0; });
  }
  return good;
}

}  // namespace

bool merge_config(ConfigNode& base, const ConfigNode& over, Diagnostics& diagnostics,
                  const std::string& path) {
  if (has_names(base) && over.is_map()) return patch_list(base, over, diagnostics, path);
  if (!base.is_map() || !over.is_map()) {
    base = over;
    return true;
  }
  base.mark = over.mark;
  // Reserve first: reallocation would move the entries and invalidate the views of short names.
  base.entries.reserve(base.entries.size() + over.entries.size());
  std::unordered_map<std::string_view, std::size_t> places;
  for (std::size_t i = 0; i < base.entries.size(); ++i) places.emplace(base.entries[i].key, i);
  bool good = true;
  std::unordered_set<std::string> removed;
  for (const ConfigEntry& entry : over.entries) {
    const auto known = places.find(entry.key);
    if (known == places.end()) {
      base.entries.push_back(entry);
    } else if (entry.value.is_null()) {
      removed.insert(entry.key);
    } else {
      good = merge_config(base.entries[known->second].value, entry.value, diagnostics,
                          path + (path.empty() ? "" : ".") + entry.key) &&
             good;
    }
  }
  if (!removed.empty()) {
    std::erase_if(base.entries, [&](const ConfigEntry& e) { return removed.count(e.key) > 0; });
  }
  return good;
}

}  // namespace skybody
