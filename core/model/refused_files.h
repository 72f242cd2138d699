// Plugin libraries that must not be opened because they end the process.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace skybody {

/// Library files (canonical paths) that must not be opened, with the reasons.
using RefusedFiles = std::map<std::filesystem::path, std::string>;

}  // namespace skybody
