#include "core/plugin_host/instance.h"

#include <string>

#include "core/base/simd/fp_environment.h"
#include "core/base/system/plugin_call_trace.h"

namespace skybody {

std::shared_ptr<const void> create_instance(const PluginEntry& entry, const SkybodySetup& setup,
                                            const SkybodyDeclare& declare) {
  if (!entry.failure.empty() || entry.descriptor == nullptr) {
    throw PluginLoadError(LoadFailure::kNotLoadable, entry.file, entry.failure);
  }
  const FpEnvironment guard;
  const SkybodyPlugin& plugin = *entry.descriptor;
  std::string error(2048, '\0');
  void* self = nullptr;
  {
    const PluginPhase phase(entry.file, "in configure() of `" + entry.name + "`");
    self = plugin.create(&setup, &declare, error.data(), error.size());
  }
  if (self == nullptr) {
    error.resize(error.find('\0') == std::string::npos ? error.size() : error.find('\0'));
    throw PluginConfigureError(entry.name, error.empty() ? "gives no reason" : error);
  }
  const auto destroy = plugin.destroy;
  // The deleter holds the library, so that it is unloaded after the instance.
  return {static_cast<const void*>(self), [destroy, library = entry.library](const void* instance) {
            const PluginPhase phase(library->file(), "in its destructor");
            destroy(const_cast<void*>(instance));
          }};
}

const SkybodyKernels& kernels_for(const SkybodyPlugin& plugin, Isa isa, SkybodyNumber number) {
  return plugin.kernels[number][static_cast<int>(isa)];
}

}  // namespace skybody
