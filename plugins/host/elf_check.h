// What can be said about a library without running any of it.
#pragma once

#include <filesystem>

namespace skybody {

/// What is said of a file that cannot be a library.
inline constexpr const char* kNoRegularFile =
    "is no regular file, but a device, a pipe or a folder";

/// Looks at a file through a read-only mapping, whatever its size, and refuses what the dynamic
/// linker would stumble over or load in vain: a device or pipe, a library for another machine, one
/// that is cut short or whose end was never written, and one that is no plugin. A file that is no
/// ELF file at all is left to the dynamic linker, which refuses it.
/// @throws PluginLoadError
void check_library_file(const std::filesystem::path& file);

}  // namespace skybody
