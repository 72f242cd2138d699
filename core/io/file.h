// Reading files whole, and paths relative to the file in which they are written.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "core/io/diagnostics.h"

namespace skybody {

/// What marks a position on the command line: the text before the override.
inline constexpr const char* kOverridePrefix = "--set ";

/// The same of a reference that the command line names.
inline constexpr const char* kReferencePrefix = "--reference ";

/// Whether a mark's file is one of these: such texts have no lines, and paths in them start at the
/// working directory.
bool is_from_command_line(const std::string& file);

/// Reads a regular file of up to `most_bytes` into `text`. Nothing is waited for, also where a pipe
/// takes the file's place meanwhile. Returns why it was not read ("is a folder"), or an empty text.
std::string read_regular_file(const std::string& path, std::size_t most_bytes, std::string& text);

/// The contents of `path`, or nothing and an error at `used_at` (or at the file, if `used_at` names
/// none). Only regular files of up to 16 MiB are read; anything else (folders,
/// devices, pipes) is an error, and nothing is waited for.
std::optional<std::string> read_file(const std::string& path, const SourceLocation& used_at,
                                     Diagnostics& diagnostics);

/// `path` as written at `mark`: relative paths start at the folder of the file that holds them, or
/// at the working directory when they come from the command line.
std::string resolve_path(const std::string& path, const SourceLocation& mark);

/// `path` from the root of the file system on, for files that are read from another folder.
std::string absolute_path(const std::string& path);

/// Whether `path` names an existing regular file.
bool is_file(const std::string& path);

}  // namespace skybody
