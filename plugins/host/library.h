// One plugin library: opened, checked, kept open.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "plugins/api/abi.h"
#include "plugins/host/load_error.h"

namespace skybody {

/// A shared library whose handshake has succeeded. Its code stays mapped as long as this lives.
class PluginLibrary {
 public:
  /// Loads `file` and checks it: symbol, magic, API version, structure sizes, floating-point probe,
  /// descriptors, in this order and nothing else before. The calling thread's floating-point mode
  /// is what it was afterwards, whatever the library's start-up code does. A file that is no plugin
  /// is recognised without running its code.
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
