// Needs POSIX's fsync() for files and folders. A name is durable only after its folder is synced,
// and a rename is atomic only within one folder.
#include "core/io/files/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>

#include "core/base/math/hash.h"
#include "core/base/system/error.h"

namespace skybody {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, int error) {
  throw Error("cannot write " + file.string() + ": " + std::strerror(error));
}

/// A file descriptor, closed by the destructor.
class Opened {
 public:
  Opened(const fs::path& path, int flags) : number_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {
    if (number_ < 0) fail(path, errno);
  }
  ~Opened() { ::close(number_); }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

void sync(const fs::path& path) {
  const Opened opened(path, O_RDONLY);
  if (::fsync(opened.number()) != 0) fail(path, errno);
}

void write_all(int descriptor, std::string_view bytes, const fs::path& file) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(file, errno);
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

void write_and_rename(const fs::path& file, const fs::path& partial, std::string_view bytes) {
  {
    const Opened opened(partial, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW);
    write_all(opened.number(), bytes, file);
    if (::fsync(opened.number()) != 0) fail(file, errno);
  }
  if (::rename(partial.c_str(), file.c_str()) != 0) fail(file, errno);
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

}  // namespace

fs::path partial_name(const fs::path& file) {
  std::random_device draw;  // the kernel's random numbers
  const std::uint64_t high = draw();
  return folder_of(file) / ("." + file.filename().string() + "." + to_hex(high << 32 | draw()));
}

void write_file_atomically(const fs::path& file, std::string_view bytes) {
  const fs::path partial = partial_name(file);
  try {
    write_and_rename(file, partial, bytes);
  } catch (const Error&) {
    ::unlink(partial.c_str());
    throw;
  }
  sync(folder_of(file));
}

}  // namespace skybody
