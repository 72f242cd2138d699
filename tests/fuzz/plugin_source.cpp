#include "tests/fuzz/plugin_source.h"

#include <cstdio>

#include "app/plugin_child.h"
#include "core/plugin_host/registry.h"
#include "tests/fuzz/finding.h"

namespace skybody::fuzz {
namespace {
constexpr unsigned kPatience = 2;  // [s]; the fuzzer treats longer calls as a hang
}

std::shared_ptr<const PluginRegistry> shipped_plugins() {
  static const auto registry =
      std::make_shared<const PluginRegistry>(std::vector{shipped_plugin_folder()});
  return registry;
}

std::vector<std::string> plugin_words() {
  std::vector<std::string> words;
  for (const PluginEntry* entry : shipped_plugins()->open_all()) {
    words.push_back(entry->name);
    for (const ParameterSpec& parameter : entry->parameters) words.push_back(parameter.name);
  }
  return words;
}

std::filesystem::path plugin_file(const std::string& name) {
  return shipped_plugin_folder() / (name + ".so");
}

std::string plugin_failure(const std::filesystem::path& folder) {
  const ChildOutput child = output_of_child(
      [&](const RefusedFiles& refused) {
        const PluginRegistry registry({folder}, refused);
        const auto entries = registry.open_all();
        if (entries.size() != 1) wrong_answer("the registry does not mention the file");
        std::fputs(entries.front()->failure.c_str(), stdout);
        return 0;
      },
      kPatience);
  if (child.status == 0) return child.out;
  // A changed library may have damaged memory; if no library was opened, the fault is ours.
  const std::string line = child.err.substr(0, child.err.find('\n'));
  if (line.find("damaged its memory") == line.npos) wrong_answer(line);
  return line;
}

}  // namespace skybody::fuzz
