// Errors of loading a plugin's file and of creating an instance.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/system/error.h"
#include "core/base/system/printable.h"
#include "core/plugin_abi/abi.h"

namespace skybody {

/// Reason why a file was refused, in the order of the checks.
enum class LoadFailure {
  kNotTrusted,      ///< another user may write it
  kEndsProcess,     ///< a process that opened it has ended
  kNotLoadable,     ///< not a library of this machine, truncated, or refused by the dynamic linker
  kNoPlugin,        ///< it does not export skybody_plugin_library
  kWrongMagic,      ///< the symbol is a different object
  kWrongVersion,    ///< another plugin API
  kWrongSize,       ///< another layout of a structure of the API
  kFloatingPoint,   ///< compiled with flags that change results
  kBadDescription,  ///< its descriptor contradicts itself
  kOtherPlugin      ///< it does not contain the plugin that its name or sidecar promises
};

/// Message about a library that is not a plugin.
constexpr const char* kNoPluginSymbol =
    "is no plugin: it does not export `" SKYBODY_LIBRARY_SYMBOL
    "`; a plugin says SKYBODY_PLUGIN(Class, name, version, doc) once";

/// A file that cannot be used as a plugin. The message contains the file, the value found, the
/// expected value and the remedy.
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

/// A plugin that refuses a scenario. The message is the plugin's own text.
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
