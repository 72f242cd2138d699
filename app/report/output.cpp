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

/// Whether the reader of a pipe has ended, as `| head` does: what it does not read is not missed.
bool reader_has_left = false;

void check(bool written) {
  if (written || reader_has_left) return;
  if (errno != EPIPE) fail(errno);
  reader_has_left = true;
}

}  // namespace

void print(const std::string& text) {
  errno = 0;
  check(std::fputs(text.c_str(), stdout) >= 0);
}

void flush_output() {
  errno = 0;
  check(std::fflush(stdout) == 0 && std::ferror(stdout) == 0);
}

}  // namespace skybody
