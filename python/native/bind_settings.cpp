#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/base/system/suggestion.h"
#include "core/io/files/shipped_files.h"
#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/include_chain.h"
#include "python/native/bindings.h"

namespace skybody::python {
namespace {

/// A value in the form of `--set KEY=VALUE`: a list as its entries with commas between them. None,
/// and an error, if it is neither a scalar nor a list.
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

nb::dict section_of(const ConfigEntry& section, Diagnostics& diagnostics) {
  nb::dict values;
  if (!section.value.is_map()) {
    diagnostics.error(section.value.mark, "`" + section.key + "` is " + section.value.describe() +
                                              "; it must be a map of keys and values");
  }
  for (const ConfigEntry& entry : section.value.entries) {
    if (const auto text = text_of(entry, diagnostics)) {
      values[entry.key.c_str()] = nb::make_tuple(*text, to_string(entry.key_mark));
    }
  }
  return values;
}

nb::dict read_settings(const std::string& file) {
  Diagnostics diagnostics;
  nb::dict sections;
  const std::optional<ConfigNode> root = load_config(file, diagnostics);
  if (root) {
    for (const ConfigEntry& section : root->entries) {
      sections[section.key.c_str()] =
          nb::make_tuple(section_of(section, diagnostics), to_string(section.key_mark));
    }
  }
  diagnostics.throw_if_errors();
  return sections;
}

}  // namespace

void bind_settings(nb::module_& m) {
  m.def("read_settings", &read_settings, nb::arg("file"),
        nb::sig("def read_settings(file: str) -> "
                "dict[str, tuple[dict[str, tuple[str, str]], str]]"),
        "Sections of a YAML file: ({key: (value as text, place)}, place) of each; a place is "
        "`file:line:column`.\nRaises InputError, with places, where it is something else.");
  m.def("shipped_scenarios", &shipped_scenarios, "Names of all shipped scenarios, sorted.");
  m.def("shipped_policies", &shipped_policies,
        "Names of all shipped scenarios with a shipped policy, sorted.");
  m.def("scenario_file", &scenario_file, nb::arg("scenario"),
        "The file that `scenario` means: itself, or that of a shipped scenario of this name.");
  m.def(
      "training_presets",
      [](const std::string& scenario) { return training_presets(scenario_file(scenario)); },
      nb::arg("scenario"),
      "The file of the presets of a scenario's training: `training/NAME.yaml` beside it, else that "
      "of the nearest scenario that it includes. If there is none, its own place.");
}

}  // namespace skybody::python
