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

}  // namespace

void print(const std::string& text) {
  errno = 0;
  if (std::fputs(text.c_str(), stdout) < 0) fail(errno);
}

void flush_output() {
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) fail(errno);
}

}  // namespace skybody
