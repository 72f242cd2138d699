#include "python/native/loaded_scenario.h"

#include <nanobind/nanobind.h>

#include <utility>

#include "core/env/param_access.h"
#include "core/plugin_host/registry.h"

namespace skybody::python {
namespace nb = nanobind;

LoadedScenario::LoadedScenario(LoadOptions options) : options_(std::move(options)) {
  const nb::gil_scoped_release release;
  compiled_ = compile_scenario(options_);
}

std::map<std::string, std::string> LoadedScenario::plugins() const {
  const auto registry = find_plugins(options_);
  std::map<std::string, std::string> versions;
  const auto add = [&](const PluginInstance& instance) {
    const PluginEntry* entry = registry->find(instance.kind, instance.plugin);
    if (entry != nullptr) versions[instance.plugin] = entry->version;
  };
  for (int kind = 0; kind < SKYBODY_KIND_COUNT; ++kind) {
    for (const PluginInstance& p : compiled_->plugins(static_cast<SkybodyKind>(kind))) add(p);
  }
  return versions;
}

void LoadedScenario::check_vector(const std::string& path, std::size_t count) const {
  try {
    check_vector_size(compiled_->scenario(), compiled_->layout(), path, count);
  } catch (const Error& e) {
    throw nb::value_error(e.what());
  }
}

void LoadedScenario::check_one_value(const std::string& path) const {
  try {
    skybody::check_one_value(compiled_->scenario(), compiled_->layout(), path);
  } catch (const Error& e) {
    throw nb::value_error(e.what());
  }
}

const EnvParam& LoadedScenario::param(const std::string& path) const {
  const int index = compiled_->layout().find_param(path);
  if (index < 0) {
    throw nb::value_error(
        ("nothing randomizable is called `" + path + "`: param_paths lists what there is").c_str());
  }
  return compiled_->layout().param_info[static_cast<std::size_t>(index)];
}

}  // namespace skybody::python
