#include "tests/fuzz/worker.h"

#include <cxxabi.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>

#include "core/base/math/hash.h"

namespace skybody::fuzz {
namespace {

std::string demangled(const char* name) {
  int failed = 0;
  char* text = abi::__cxa_demangle(name, nullptr, nullptr, &failed);
  const std::string result = failed == 0 ? text : name;
  free(text);
  return result.substr(0, result.find('('));
}

/// `library+offset (function)`, readable by addr2line and by people.
std::string frame_name(void* address) {
  Dl_info info{};
  if (dladdr(address, &info) == 0 || info.dli_fname == nullptr) return "?";
  char offset[32];
  std::snprintf(
      offset, sizeof offset, "+0x%zx",
      static_cast<std::size_t>(static_cast<char*>(address) - static_cast<char*>(info.dli_fbase)));
  const std::string file = std::filesystem::path(info.dli_fname).filename().string() + offset;
  return info.dli_sname == nullptr ? file : file + " (" + demangled(info.dli_sname) + ")";
}

/// Omits the handler's own frames.
std::string trace(const Progress& progress) {
  constexpr int kOwn = 2, kMost = 8;
  std::string text;
  for (int k = kOwn; k < std::min(progress.frame_count, kOwn + kMost); ++k) {
    text +=
        (text.empty() ? ": " : " < ") + frame_name(progress.frames[static_cast<std::size_t>(k)]);
  }
  return text;
}

void silence(int descriptor) {
  const int null = open("/dev/null", O_RDWR);
  dup2(null, descriptor);
  close(null);
}

}  // namespace

Worker::Worker(std::filesystem::path folder, const Limits& limits, bool quiet)
    : folder_(std::move(folder)), limits_(limits), quiet_(quiet), progress_(Progress::make()) {}

void Worker::start(const Block& block) {
  block_ = block;
  progress_->clear();
  starts_seen_ = 0;
  input_processor_ = 0.0;
  std::filesystem::remove_all(folder_);
  std::filesystem::create_directories(folder_);
  std::fflush(nullptr);
  began_ = input_began_ = Clock::now();
  child_ = fork();
  if (child_ < 0) throw std::runtime_error("cannot start a process");
  if (child_ == 0) run_child();
}

void Worker::run_child() {
  silence(STDIN_FILENO);
  if (quiet_) {
    silence(STDOUT_FILENO);
    silence(STDERR_FILENO);
  }
  guard_process(limits_, *progress_);
  try {
    run_block(block_, folder_, *progress_);
  } catch (const std::exception& error) {
    progress_->note(FindingKind::kWrongAnswer, std::string("cannot begin: ") + error.what());
    progress_->finished = true;
  }
  _exit(0);
}

double Worker::processor_seconds() const {
  clockid_t clock;
  timespec time{};
  if (clock_getcpuclockid(child_, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0.0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

bool Worker::takes_too_long() {
  const double processor = processor_seconds();
  const Clock::time_point now = Clock::now();
  if (progress_->starts != starts_seen_) {
    starts_seen_ = progress_->starts;
    input_began_ = now;
    input_processor_ = processor;
    return false;
  }
  return processor - input_processor_ > limits_.processor_seconds ||
         std::chrono::duration<double>(now - input_began_).count() > limits_.wall_seconds;
}

Found Worker::crash(int status) const {
  const std::string how = WIFSIGNALED(status)
                              ? std::string("signal ") + strsignal(WTERMSIG(status))
                              : "exit status " + std::to_string(WEXITSTATUS(status));
  return {progress_->input, FindingKind::kCrash, how + trace(*progress_)};
}

BlockEnd Worker::end(std::optional<Found> found) {
  child_ = 0;
  const std::uint64_t done = progress_->refused + progress_->accepted;
  const bool one_more = found.has_value() && !progress_->repeating;  // the input of the finding
  return {block_.first + done + (one_more ? 1 : 0),
          progress_->refused,
          progress_->accepted,
          progress_->slowest_ns,
          progress_->slowest_input,
          std::chrono::duration<double>(Clock::now() - began_).count(),
          std::move(found)};
}

std::optional<BlockEnd> Worker::poll() {
  int status = 0;
  if (waitpid(child_, &status, WNOHANG) != child_) {
    if (!takes_too_long()) return std::nullopt;
    kill(child_, SIGKILL);
    waitpid(child_, &status, 0);
    return end(Found{progress_->input, FindingKind::kHang, "does not end"});
  }
  if (!progress_->finished) return end(crash(status));
  if (!progress_->has_finding) return end(std::nullopt);
  return end(Found{progress_->input, progress_->kind, progress_->text.data()});
}

}  // namespace skybody::fuzz
