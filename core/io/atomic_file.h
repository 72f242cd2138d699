// Files that are there whole or not at all, also after a power cut or kill -9.
#pragma once

#include <filesystem>
#include <string_view>

namespace skybody {

/// A name in the folder of `file` for what is not whole yet. Nobody can foresee it and put a link
/// there, through which another file would be written.
std::filesystem::path partial_name(const std::filesystem::path& file);

/// Replaces `file`: the bytes are written under another name in its folder, brought to the disk,
/// and get the file's name last.
/// @throws Error with the file and the operating system's reason; the file is then as it was
void write_file_atomically(const std::filesystem::path& file, std::string_view bytes);

}  // namespace skybody
