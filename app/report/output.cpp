#include "app/report/output.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/base/system/error.h"

namespace skybody {
namespace {

[[noreturn]] void fail(int error) {
  throw Error(std::string("cannot write the standard output: ") +
              (error != 0 ? std::strerror(error)
                          : "an earlier write to it failed, and the system no longer says why"));
}

/// Whether the reader has closed the pipe, as `| head` does; further output is dropped.
bool is_pipe_closed = false;

/// @throws Error if a write failed for another reason than a closed pipe
void check_written(bool written) {
  if (written || is_pipe_closed) return;
  if (errno != EPIPE) fail(errno);
  is_pipe_closed = true;
}

}  // namespace

void print(const std::string& text) {
  errno = 0;
  check_written(std::fputs(text.c_str(), stdout) >= 0);
}

void flush_output() {
  errno = 0;
  check_written(std::fflush(stdout) == 0 && std::ferror(stdout) == 0);
}

}  // namespace skybody
