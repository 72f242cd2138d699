// Needs POSIX files: only open() with O_NONBLOCK is sure not to block on a pipe that replaces a
// regular file between the check of the name and the opening. The bytes read are counted against
// the limit, because files of /proc and /sys report a size of 0 and may never end.
#include "core/io/files/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/io/files/missing_file.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestFile = 16u << 20;  // [bytes]; the largest shipped file has 8 kB

constexpr const char* kMissing = "does not exist";

/// A file descriptor, closed by the destructor.
class Descriptor {
 public:
  explicit Descriptor(const std::string& path)
      : number_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number() const { return number_; }
  bool is_open() const { return number_ >= 0; }

 private:
  int number_;
};

std::string reason_of_errno() { return std::string("cannot be read: ") + std::strerror(errno); }

std::string too_large(std::size_t most_bytes) {
  return "is larger than " + std::to_string(most_bytes >> 20) + " MiB";
}

/// The reason why a file with this status is not read, or an empty text.
std::string obstacle(const struct stat& status, std::size_t most_bytes) {
  if (S_ISDIR(status.st_mode)) return "is a folder";
  if (!S_ISREG(status.st_mode)) return "is not a regular file";
  const bool fits = static_cast<std::size_t>(status.st_size) <= most_bytes;
  return fits ? "" : too_large(most_bytes);
}

/// The reason why `path` is not opened, or an empty text.
std::string obstacle_to_opening(const std::string& path, std::size_t most_bytes) {
  if (path.find('\0') != path.npos) return "cannot exist: its name has a NUL character";
  struct stat status;
  if (::stat(path.c_str(), &status) == 0) return obstacle(status, most_bytes);
  return errno == ENOENT || errno == ENOTDIR ? kMissing : reason_of_errno();
}

/// Reads `path` into `text`. @returns the reason of a failure, or an empty text
std::string read_into(const std::string& path, std::size_t most_bytes, std::string& text) {
  const Descriptor file(path);
  if (!file.is_open()) return reason_of_errno();
  struct stat status;
  if (::fstat(file.number(), &status) != 0) return reason_of_errno();
  const std::string problem = obstacle(status, most_bytes);
  if (!problem.empty()) return problem;
  text.reserve(static_cast<std::size_t>(status.st_size));
  std::array<char, 65536> buffer;
  for (;;) {
    const ssize_t count = ::read(file.number(), buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return reason_of_errno();
    if (count == 0) return "";
    text.append(buffer.data(), static_cast<std::size_t>(count));
    if (text.size() > most_bytes) return too_large(most_bytes);
  }
}

}  // namespace

std::string read_regular_file(const std::string& path, std::size_t most_bytes, std::string& text) {
  const std::string problem = obstacle_to_opening(path, most_bytes);
  return problem.empty() ? read_into(path, most_bytes, text) : problem;
}

std::optional<std::string> read_file(const std::string& path, const SourceLocation& used_at,
                                     Diagnostics& diagnostics) {
  std::string text;
  const std::string problem = read_regular_file(path, kLargestFile, text);
  if (problem.empty()) return text;
  const std::string near = problem == kMissing ? similar_file(path) : "";
  const std::string hint = near.empty() ? "" : "; did you mean `" + near + "`?";
  if (used_at.file.empty()) {
    diagnostics.error({path, 0, 0}, "the file " + problem + hint);
  } else {
    diagnostics.error(used_at, "the file `" + path + "` " + problem + hint);
  }
  return std::nullopt;
}

bool is_from_command_line(const std::string& file) {
  return file.rfind(kOverridePrefix, 0) == 0 || file.rfind(kReferencePrefix, 0) == 0;
}

std::string resolve_path(const std::string& path, const SourceLocation& mark) {
  if (path.empty() || fs::path(path).is_absolute() || is_from_command_line(mark.file)) return path;
  return (fs::path(mark.file).parent_path() / path).lexically_normal().string();
}

std::string absolute_path(const std::string& path) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(path, error);
  return error ? path : whole.string();
}

bool is_file(const std::string& path) {
  std::error_code code;
  return path.find('\0') == path.npos && fs::is_regular_file(path, code);
}

}  // namespace skybody
