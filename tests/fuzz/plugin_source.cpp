#include "tests/fuzz/plugin_source.h"

#include "plugins/host/registry.h"
#include "tests/fuzz/finding.h"

namespace skybody::fuzz {

std::shared_ptr<const PluginRegistry> shipped_plugins() {
  static const auto registry =
      std::make_shared<const PluginRegistry>(std::vector{shipped_plugin_folder()});
  return registry;
}

std::vector<std::string> plugin_words() {
  std::vector<std::string> words;
  for (const PluginEntry& entry : shipped_plugins()->entries()) {
    words.push_back(entry.name);
    for (const ParameterSpec& parameter : entry.parameters) words.push_back(parameter.name);
  }
  return words;
}

std::filesystem::path plugin_file(const std::string& name) {
  return shipped_plugin_folder() / (name + ".so");
}

std::string plugin_failure(const std::filesystem::path& folder) {
  const PluginRegistry registry({folder});
  if (registry.entries().size() != 1) wrong_answer("the registry does not mention the file");
  return registry.entries().front().failure;
}

}  // namespace skybody::fuzz
