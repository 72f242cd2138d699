#include "core/io/config_tree.h"

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

void merge_config(ConfigNode& base, const ConfigNode& over) {
  if (!base.is_map() || !over.is_map()) {
    base = over;
    return;
  }
  base.mark = over.mark;
  for (const ConfigEntry& entry : over.entries) {
    ConfigNode* existing = base.find(entry.key);
    if (existing == nullptr) {
      base.entries.push_back(entry);
    } else {
      merge_config(*existing, entry.value);
    }
  }
}

}  // namespace skybody
