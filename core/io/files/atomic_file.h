// Atomic file writes: the complete file or none, also after a power cut or kill -9.
#pragma once

#include <filesystem>
#include <string_view>

namespace skybody {

/// A name for an incomplete file in the folder of `file`. It is random, so that nobody can place a
/// link there in advance to redirect the write to another file.
std::filesystem::path partial_name(const std::filesystem::path& file);

/// Replaces `file` in three steps:
/// 1. write the bytes under another name in the same folder
/// 2. sync them to the disk
/// 3. rename to `file`
/// @throws Error with the file and the operating system's reason; `file` is then unchanged
void write_file_atomically(const std::filesystem::path& file, std::string_view bytes);

}  // namespace skybody
