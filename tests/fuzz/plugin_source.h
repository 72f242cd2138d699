// The only part of the fuzzers that uses the plugin registry.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/assemble/compile_scenario.h"

namespace skybody::fuzz {

/// The shipped plugins, opened once for all loaded scenarios.
std::shared_ptr<const PluginRegistry> shipped_plugins();

/// Names of the plugins and of their parameters: words of scenarios.
std::vector<std::string> plugin_words();

/// Path of a shipped plugin.
std::filesystem::path plugin_file(const std::string& name);

/// The reason why a folder's only library cannot be used, or "". The library is opened in a child
/// process, as in `skybody plugins`.
std::string plugin_failure(const std::filesystem::path& folder);

}  // namespace skybody::fuzz
