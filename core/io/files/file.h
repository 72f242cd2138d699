// Reads whole files, and resolves paths relative to the files that contain them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Prefix of a command-line location: the text before the override.
inline constexpr const char* kOverridePrefix = "--set ";

/// Prefix of a location in the command line's --reference.
inline constexpr const char* kReferencePrefix = "--reference ";

/// Whether a location's file is one of these. Such texts have no lines, and their paths are
/// relative to the working directory.
bool is_from_command_line(const std::string& file);

/// Reads a regular file of up to `most_bytes` into `text`. Never blocks, even if a pipe replaces
/// the file meanwhile. Returns the reason of a failure ("is a folder"), or an empty text.
std::string read_regular_file(const std::string& path, std::size_t most_bytes, std::string& text);

/// The contents of `path`, or nullopt and an error at `used_at` (at the file, if `used_at` is
/// empty). Reads only regular files of up to 16 MiB; folders, devices and pipes are errors. Never
/// blocks.
std::optional<std::string> read_file(const std::string& path, const SourceLocation& used_at,
                                     Diagnostics& diagnostics);

/// Resolves `path`, written at `mark`: relative paths start at the folder of the file of `mark`, or
/// at the working directory if they come from the command line.
std::string resolve_path(const std::string& path, const SourceLocation& mark);

/// `path` as an absolute path, for files that are read from another folder.
std::string absolute_path(const std::string& path);

/// Whether `path` names an existing regular file.
bool is_file(const std::string& path);

}  // namespace skybody
