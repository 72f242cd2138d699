#include "app/report/progress_line.h"

#include <unistd.h>

#include <cstdio>

namespace skybody {
namespace {

constexpr std::chrono::milliseconds kPeriod(100);
constexpr const char* kClearLine = "\r\033[K";

}  // namespace

ProgressLine::ProgressLine()
    : terminal_(isatty(STDERR_FILENO) != 0), next_(std::chrono::steady_clock::now() + kPeriod) {}

bool ProgressLine::is_due() { return terminal_ && std::chrono::steady_clock::now() >= next_; }

void ProgressLine::show(const std::string& text) {
  std::fprintf(stderr, "%s%s", kClearLine, text.c_str());
  std::fflush(stderr);
  next_ = std::chrono::steady_clock::now() + kPeriod;
  shown_ = true;
}

void ProgressLine::clear() {
  if (!shown_) return;
  std::fputs(kClearLine, stderr);
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace skybody
