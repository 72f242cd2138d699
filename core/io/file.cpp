#include "core/io/file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace skybody {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestFile = 64u << 20;

/// Why `path` cannot be read, or an empty text.
std::string obstacle_to_reading(const std::string& path) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (!fs::exists(status)) return "does not exist";
  if (fs::is_directory(status)) return "is a folder";
  if (!fs::is_regular_file(status)) return "is not a regular file";
  if (fs::file_size(path, code) > kLargestFile) return "is larger than 64 MiB";
  return "";
}

}  // namespace

std::optional<std::string> read_file(const std::string& path, const SourceMark& used_at,
                                     Diagnostics& diagnostics) {
  std::string problem = obstacle_to_reading(path);
  std::string text;
  if (problem.empty()) {
    std::ifstream stream(path, std::ios::binary);
    std::ostringstream buffer;
    if (stream && stream.peek() != std::ifstream::traits_type::eof()) buffer << stream.rdbuf();
    if (stream.bad() || !stream.is_open()) {
      problem = std::string("cannot be read: ") + std::strerror(errno);
    }
    text = buffer.str();
  }
  if (problem.empty()) return text;
  if (used_at.file.empty()) {
    diagnostics.error({path, 0, 0}, "the file " + problem);
  } else {
    diagnostics.error(used_at, "the file `" + path + "` " + problem);
  }
  return std::nullopt;
}

std::string resolve_path(const std::string& path, const SourceMark& mark) {
  const bool from_command_line = mark.file.rfind(kOverridePrefix, 0) == 0;
  if (path.empty() || fs::path(path).is_absolute() || from_command_line) return path;
  return (fs::path(mark.file).parent_path() / path).lexically_normal().string();
}

bool is_file(const std::string& path) {
  std::error_code code;
  return fs::is_regular_file(path, code);
}

}  // namespace skybody
