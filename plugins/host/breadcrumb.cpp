#include "plugins/host/breadcrumb.h"

#include <unistd.h>

#include <cstdio>

namespace skybody {
namespace {
Breadcrumb* watched = nullptr;
unsigned longest_phase = 0;  // [s]
}  // namespace

void watch_plugins(Breadcrumb* where, unsigned patience) {
  watched = where;
  longest_phase = patience;
}

PluginPhase::PluginPhase(const std::filesystem::path& file, const std::string& phase) {
  if (watched == nullptr) return;
  std::snprintf(watched->file, sizeof watched->file, "%s", file.c_str());
  std::snprintf(watched->phase, sizeof watched->phase, "%s", phase.c_str());
  if (longest_phase > 0) alarm(longest_phase);
}

PluginPhase::~PluginPhase() {
  if (watched == nullptr) return;
  watched->phase[0] = '\0';
  if (longest_phase > 0) alarm(0);
}

}  // namespace skybody
