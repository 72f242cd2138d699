// A record of the running plugin call. After a crash, a parent process or a handler of signals or
// of exit() reads it to name the plugin.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>

namespace skybody {

/// Plain memory that processes may share.
struct PluginCallTrace {
  char file[4096];  ///< the library; Linux limits paths to this length
  char phase[256];  ///< such as "while it is loaded"; empty: no plugin code is running
  std::atomic<std::uint32_t> phases;  ///< number of phases begun, to distinguish them
};

/// Records the phases of the calling thread in `where` from now on. Null, the initial state:
/// nothing is recorded.
void watch_plugins(PluginCallTrace* where);

/// RAII record of a call into a plugin: loading, configure(), unloading; steps in checked mode.
class PluginPhase {
 public:
  PluginPhase(const std::filesystem::path& file, const std::string& phase);
  ~PluginPhase();
  PluginPhase(const PluginPhase&) = delete;
  PluginPhase& operator=(const PluginPhase&) = delete;
};

}  // namespace skybody
