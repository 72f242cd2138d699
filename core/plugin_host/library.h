// Opens and checks one plugin library and keeps it open.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "core/plugin_abi/abi.h"
#include "core/plugin_host/load_error.h"

namespace skybody {

/// A shared library whose handshake has succeeded. Its code stays mapped during this object's life.
class PluginLibrary {
 public:
  /// Loads `file` and checks it, in this order: symbol, magic, API version, structure sizes,
  /// floating-point probe, descriptors. No other code of it is called before. Restores the calling
  /// thread's floating-point mode, whatever the library's start-up code does. A file that is not a
  /// plugin is recognised without running its code.
  /// @throws PluginLoadError
  explicit PluginLibrary(const std::filesystem::path& file);
  ~PluginLibrary();
  PluginLibrary(const PluginLibrary&) = delete;
  PluginLibrary& operator=(const PluginLibrary&) = delete;

  /// The canonical path.
  const std::filesystem::path& file() const { return file_; }
  /// The checked descriptors; they live in the library.
  const std::vector<const SkybodyPlugin*>& plugins() const { return plugins_; }

 private:
  struct Handle;  // keeps Boost out of this header

  std::filesystem::path file_;
  std::unique_ptr<Handle> handle_;
  std::vector<const SkybodyPlugin*> plugins_;
};

}  // namespace skybody
