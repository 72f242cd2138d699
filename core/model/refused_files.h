// Plugin libraries that are known to end the process that opens them.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace skybody {

/// Library files (canonical paths) that must not be opened, and why.
using RefusedFiles = std::map<std::filesystem::path, std::string>;

}  // namespace skybody
