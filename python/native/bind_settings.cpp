#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>

#include "core/assemble/compile_scenario.h"
#include "core/io/files/shipped_files.h"
#include "core/io/yaml/diagnostics.h"
#include "core/io/yaml/include_chain.h"
#include "learn/preset.h"
#include "learn/preset_file.h"
#include "python/native/bindings.h"
#include "python/native/learner_options.h"

namespace skybody::python {
namespace {

nb::dict read_settings(const std::string& file) {
  nb::dict sections;
  for (const learn::PresetSection& section : learn::read_preset_file(file)) {
    nb::dict values;
    for (const learn::PresetValue& value : section.values) {
      values[value.key.c_str()] = nb::make_tuple(value.text, to_string(value.mark));
    }
    sections[section.learner.c_str()] = nb::make_tuple(values, to_string(section.mark));
  }
  return sections;
}

nb::tuple read_preset(const std::string& scenario, const std::string& algorithm,
                      double action_seconds) {
  const learn::Algorithm which = algorithm_of(algorithm);
  const learn::Preset preset = learn::read_preset(scenario, which, action_seconds);
  return nb::make_tuple(dict_of(preset.hyper, which), preset.total_steps);
}

}  // namespace

void bind_settings(nb::module_& m) {
  m.def("read_settings", &read_settings, nb::arg("file"),
        nb::sig("def read_settings(file: str) -> "
                "dict[str, tuple[dict[str, tuple[str, str]], str]]"),
        "Sections of a YAML file: ({key: (value as text, place)}, place) of each; a place is "
        "`file:line:column`.\nRaises InputError, with places, where it is something else.");
  m.def("read_preset", &read_preset, nb::arg("scenario"), nb::arg("algorithm"),
        nb::arg("action_seconds") = 0.0,
        nb::sig("def read_preset(scenario: str, algorithm: str, action_seconds: float = 0.0) -> "
                "tuple[dict[str, typing.Any], int]"),
        "The preset of a scenario for a learner in C++: its hyper-parameters and its number of "
        "steps.\naction_seconds: between two actions, for scenarios without a preset; 0: not "
        "known.\n\nRaises InputError, with places, for a mistake in the file.");
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
