// The one place of the fuzzers that uses the registry of plugins.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/assemble/load.h"

namespace skybody::fuzz {

/// The shipped plugins, opened once for all scenarios that are loaded.
std::shared_ptr<const PluginRegistry> shipped_plugins();

/// Their names and those of their parameters: words of scenarios.
std::vector<std::string> plugin_words();

/// A shipped plugin's file.
std::filesystem::path plugin_file(const std::string& name);

/// Why a folder's only library cannot be used, or "": it is opened in a child process, as by
/// `skybody plugins`.
std::string plugin_failure(const std::filesystem::path& folder);

}  // namespace skybody::fuzz
