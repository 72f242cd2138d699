#include "core/io/config_tree.h"

#include <algorithm>
#include <string_view>
#include <unordered_map>

#include "core/io/text.h"

namespace skybody {

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
  return "the text `" + scalar + "`";
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

void merge_config(ConfigNode& base, const ConfigNode& over) {
  if (!base.is_map() || !over.is_map()) {
    base = over;
    return;
  }
  base.mark = over.mark;
  // Names stay where they are: a vector that grows moves its entries, and with them short names.
  base.entries.reserve(base.entries.size() + over.entries.size());
  std::unordered_map<std::string_view, std::size_t> places;
  for (std::size_t i = 0; i < base.entries.size(); ++i) places.emplace(base.entries[i].key, i);
  for (const ConfigEntry& entry : over.entries) {
    const auto known = places.find(entry.key);
    if (known == places.end()) {
      base.entries.push_back(entry);
    } else {
      merge_config(base.entries[known->second].value, entry.value);
    }
  }
}

}  // namespace skybody
