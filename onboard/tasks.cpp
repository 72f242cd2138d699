// The tasks that are compiled into this program: a list written by CMake.
#include <iterator>

#include "onboard/task_host.h"
#include "onboard/task_list.h"

#define SKYBODY_ROW(NAME) extern "C" const SkybodyPluginLibrary skybody_task_##NAME;
SKYBODY_ONBOARD_TASKS(SKYBODY_ROW)
#undef SKYBODY_ROW

namespace skybody::onboard {
namespace {

const SkybodyPluginLibrary* const kLibraries[] = {
#define SKYBODY_ROW(NAME) &skybody_task_##NAME,
    SKYBODY_ONBOARD_TASKS(SKYBODY_ROW)
#undef SKYBODY_ROW
};

}  // namespace

const SkybodyPlugin* find_task(const std::string& name) {
  for (const SkybodyPluginLibrary* library : kLibraries) {
    for (std::uint32_t k = 0; k < library->plugin_count; ++k) {
      const SkybodyPlugin* plugin = library->plugins[k];
      if (plugin->kind == SKYBODY_TASK && name == plugin->name) return plugin;
    }
  }
  return nullptr;
}

std::vector<std::string> task_names() {
  std::vector<std::string> names;
  for (const SkybodyPluginLibrary* library : kLibraries) {
    for (std::uint32_t k = 0; k < library->plugin_count; ++k) {
      names.emplace_back(library->plugins[k]->name);
    }
  }
  return names;
}

}  // namespace skybody::onboard
