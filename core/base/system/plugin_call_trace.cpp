#include "core/base/system/plugin_call_trace.h"

#include <cstdio>

namespace skybody {
namespace {
thread_local PluginCallTrace* watched = nullptr;
}  // namespace

void watch_plugins(PluginCallTrace* where) { watched = where; }

PluginPhase::PluginPhase(const std::filesystem::path& file, const std::string& phase) {
  if (watched == nullptr) return;
  std::snprintf(watched->file, sizeof watched->file, "%s", file.c_str());
  std::snprintf(watched->phase, sizeof watched->phase, "%s", phase.c_str());
  ++watched->phases;
}

PluginPhase::~PluginPhase() {
  if (watched != nullptr) watched->phase[0] = '\0';
}

}  // namespace skybody
