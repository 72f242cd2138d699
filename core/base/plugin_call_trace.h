// Which plugin's code is running, for those who find the process dead: a parent process, a handler
// of signals or of exit().
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>

namespace skybody {

/// Plain memory, which may be shared with another process.
struct PluginCallTrace {
  char file[4096];  ///< the library; Linux has no longer paths
  char phase[256];  ///< such as "while it is loaded"; empty: no plugin's code is running
  std::atomic<std::uint32_t> phases;  ///< how many have begun, which tells them apart
};

/// From now on phases of the calling thread are written to `where`. Null, as at the beginning:
/// nobody watches, and nothing is written.
void watch_plugins(PluginCallTrace* where);

/// Stands for a call into a plugin: loading, configure(), unloading; and steps in checked mode.
class PluginPhase {
 public:
  PluginPhase(const std::filesystem::path& file, const std::string& phase);
  ~PluginPhase();
  PluginPhase(const PluginPhase&) = delete;
  PluginPhase& operator=(const PluginPhase&) = delete;
};

}  // namespace skybody
