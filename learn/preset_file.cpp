#include "learn/preset_file.h"

#include <optional>

#include "core/base/system/suggestion.h"
#include "core/io/yaml/config_tree.h"

namespace skybody::learn {
namespace {

/// None, and an error, if the value is neither a scalar nor a list of scalars.
std::optional<std::string> text_of(const ConfigEntry& entry, Diagnostics& diagnostics) {
  if (entry.value.is_scalar()) return entry.value.scalar;
  bool is_list = entry.value.is_sequence();
  std::vector<std::string> items;
  for (const ConfigNode& item : entry.value.items) {
    is_list = is_list && item.is_scalar();
    items.push_back(item.scalar);
  }
  if (is_list) return join(items, ",");
  diagnostics.error(entry.value.mark, "`" + entry.key + "` is " + entry.value.describe() +
                                          "; it must be a value or a list of values");
  return std::nullopt;
}

PresetSection section_of(const ConfigEntry& entry, Diagnostics& diagnostics) {
  PresetSection section{entry.key, entry.key_mark, {}};
  if (!entry.value.is_map()) {
    diagnostics.error(entry.value.mark, "`" + entry.key + "` is " + entry.value.describe() +
                                            "; it must be a map of keys and values");
  }
  for (const ConfigEntry& value : entry.value.entries) {
    if (auto text = text_of(value, diagnostics)) {
      section.values.push_back({value.key, std::move(*text), value.key_mark});
    }
  }
  return section;
}

}  // namespace

std::vector<PresetSection> read_preset_file(const std::string& file) {
  Diagnostics diagnostics;
  std::vector<PresetSection> sections;
  if (const std::optional<ConfigNode> root = load_config(file, diagnostics)) {
    for (const ConfigEntry& entry : root->entries) {
      sections.push_back(section_of(entry, diagnostics));
    }
  }
  diagnostics.throw_if_errors();
  return sections;
}

}  // namespace skybody::learn
