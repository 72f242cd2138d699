// What goes wrong between a file with a plugin and an instance of it.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/error.h"
#include "core/base/printable.h"
#include "plugins/api/abi.h"

namespace skybody {

/// Why a file was refused, in the order in which it is checked.
enum class LoadFailure {
  kNotTrusted,      ///< somebody else may write it
  kEndsProcess,     ///< it has ended a process that opened it
  kNotLoadable,     ///< no library of this machine, truncated, or refused by the dynamic linker
  kNoPlugin,        ///< it does not export skybody_plugin_library
  kWrongMagic,      ///< the symbol is something else
  kWrongVersion,    ///< another plugin API
  kWrongSize,       ///< another layout of a structure of the API
  kFloatingPoint,   ///< compiled with flags that change results
  kBadDescription,  ///< its descriptor contradicts itself
  kOtherPlugin      ///< it does not hold the plugin that its name or sidecar promises
};

/// What is said of a library that is no plugin.
constexpr const char* kNoPluginSymbol =
    "is no plugin: it does not export `" SKYBODY_LIBRARY_SYMBOL
    "`; a plugin says SKYBODY_PLUGIN(Class, name, version, doc) once";

/// A file that cannot be used as a plugin. what() names the file, what was found, what is expected
/// and the remedy.
class PluginLoadError : public Error {
 public:
  PluginLoadError(LoadFailure reason, std::filesystem::path file, const std::string& message)
      : Error(printable(file.string() + ": " + message)), reason_(reason), file_(std::move(file)) {}

  LoadFailure reason() const { return reason_; }
  const std::filesystem::path& file() const { return file_; }

 private:
  LoadFailure reason_;
  std::filesystem::path file_;
};

/// A plugin that refuses a scenario. what() is the plugin's own text.
class PluginConfigureError : public Error {
 public:
  PluginConfigureError(std::string plugin, const std::string& text)
      : Error(text), plugin_(std::move(plugin)) {}

  /// The plugin's name.
  const std::string& plugin() const { return plugin_; }

 private:
  std::string plugin_;
};

}  // namespace skybody
