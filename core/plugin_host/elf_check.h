// Checks of a library that run none of its code.
#pragma once

#include <filesystem>

namespace skybody {

/// Message about a file that cannot be a library.
inline constexpr const char* kNoRegularFile =
    "is no regular file, but a device, a pipe or a folder";

/// Inspects a file of any size through a read-only mapping. Refuses files that would crash the
/// dynamic linker or be loaded in vain:
///   - a device or pipe;
///   - a library for another machine;
///   - a truncated library, or one whose end was never written;
///   - a library that is not a plugin.
/// A file that is not ELF at all is left to the dynamic linker, which refuses it.
/// @throws PluginLoadError
void check_library_file(const std::filesystem::path& file);

}  // namespace skybody
