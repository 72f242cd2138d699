// A page of memory shared with the child records the plugin whose code is running and whether the
// work was done. After the child's end it shows the cause. The exit status alone does not: exit(0)
// in a plugin looks like success, and its crash looks like one of Skybody.
#include "app/plugin_child.h"

#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <utility>

#include "app/command_work.h"
#include "app/report/output.h"
#include "app/report/report.h"
#include "core/base/system/error.h"
#include "core/base/system/plugin_call_trace.h"
#include "core/base/system/printable.h"

namespace skybody {
namespace {

using Work = std::function<int(const RefusedFiles&)>;

/// Maximum length of a child's last line in a message.
constexpr std::size_t kLongestLastWords = 300;
/// Polling interval for the child: short compared with a command, long compared with one poll.
constexpr std::chrono::milliseconds kRest(2);

[[noreturn]] void fail(const std::string& what) {
  throw Error("cannot open plugins in a process of their own: " + what + ": " +
              std::strerror(errno));
}

/// Memory shared by parent and child.
struct SharedPage {
  PluginCallTrace trace;
  bool done;
};

class Shared {
 public:
  Shared()
      : memory_(mmap(nullptr, sizeof(SharedPage), PROT_READ | PROT_WRITE,
                     MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (memory_ == MAP_FAILED) fail("mmap");
  }
  ~Shared() { munmap(memory_, sizeof(SharedPage)); }
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;
  SharedPage& operator*() const { return *static_cast<SharedPage*>(memory_); }
  SharedPage* operator->() const { return static_cast<SharedPage*>(memory_); }

 private:
  void* memory_;
};

/// A file in memory that receives the child's output.
class Capture {
 public:
  Capture() : descriptor_(memfd_create("skybody-output", MFD_CLOEXEC)) {
    if (descriptor_ < 0) fail("memfd_create");
  }
  ~Capture() { close(descriptor_); }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  /// Redirects `stream`, a descriptor of this process, to this file.
  void take(int stream) const {
    if (dup2(descriptor_, stream) < 0) _exit(kExitBug);
  }

  std::string text() const {
    std::string text;
    std::array<char, 65536> buffer;
    lseek(descriptor_, 0, SEEK_SET);
    for (ssize_t n; (n = read(descriptor_, buffer.data(), buffer.size())) > 0;) {
      text.append(buffer.data(), static_cast<std::size_t>(n));
    }
    return text;
  }

 private:
  int descriptor_;
};

/// Data about a child's end.
struct End {
  bool done = false;  ///< completed its work, including all output
  int status = 0;     ///< from waitpid()
  std::string out, err;
  bool late = false;        ///< a phase exceeded the time limit
  std::string file, phase;  ///< the plugin whose code was running; empty phase: none
};

[[noreturn]] void be_the_child(const Work& work, const RefusedFiles& refused, SharedPage& page) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // ends with a parent that is killed
  watch_plugins(&page.trace);
  const int status = run_and_report([&] { return work(refused); });
  std::fflush(nullptr);
  page.done = true;
  _exit(status);
}

/// Duration of a phase, measured by the parent, since a child may block all its own signals. It
/// counts the parent's polling intervals and not the clock, so that time in which both processes
/// are stopped does not count.
class PhaseTime {
 public:
  explicit PhaseTime(const PluginCallTrace& trace) : trace_(trace) {}

  /// Call it after each polling interval. @returns the duration of the current phase; about 0
  /// without one
  std::chrono::milliseconds after_rest() {
    const std::uint32_t phase = trace_.phases;
    if (phase != phase_ || trace_.phase[0] == '\0') time_ = {};
    phase_ = phase;
    return time_ += kRest;
  }

 private:
  const PluginCallTrace& trace_;
  std::uint32_t phase_ = 0;
  std::chrono::milliseconds time_{0};
};

/// Waits until the child ends; kills it if a phase takes longer than `patience` seconds.
void wait_for(pid_t child, unsigned patience, const SharedPage& page, End& end) {
  PhaseTime time(page.trace);
  while (true) {
    const pid_t ended = waitpid(child, &end.status, end.late ? 0 : WNOHANG);
    if (ended == child) return;
    if (ended < 0 && errno != EINTR) fail("waitpid");
    std::this_thread::sleep_for(kRest);
    if (time.after_rest() <= std::chrono::seconds(patience)) continue;
    end.late = true;
    kill(child, SIGKILL);  // cannot be blocked
  }
}

End run_child(const Work& work, const RefusedFiles& refused, unsigned patience) {
  const Shared shared;
  const Capture out, err;
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) fail("fork");
  if (child == 0) {
    out.take(STDOUT_FILENO);
    err.take(STDERR_FILENO);
    be_the_child(work, refused, *shared);
  }
  End end;
  wait_for(child, patience, *shared, end);
  end.done = shared->done;
  end.out = out.text();
  end.err = err.text();
  end.file = shared->trace.file;
  end.phase = shared->trace.phase;
  return end;
}

/// The child's last line on stderr, such as a failed assertion.
std::string last_words(const std::string& err) {
  const std::size_t last = err.find_last_not_of("\r\n ");
  if (last == std::string::npos) return {};
  const std::size_t before = err.rfind('\n', last);
  const std::size_t first =
      err.find_first_not_of(" \t", before == std::string::npos ? 0 : before + 1);
  const std::string line =
      printable(err.substr(first, std::min(last + 1 - first, kLongestLastWords)));
  return ", its last words are `" + line + "`";
}

/// "signal 11, Segmentation fault" or "exit status 0", and the child's last line
std::string how_it_ended(const End& end) {
  const std::string how = WIFSIGNALED(end.status)
                              ? "signal " + std::to_string(WTERMSIG(end.status)) + ", " +
                                    strsignal(WTERMSIG(end.status))
                              : "exit status " + std::to_string(WEXITSTATUS(end.status));
  return how + last_words(end.err);
}

/// "crashes in configure() of `x` (signal 11, Segmentation fault): mend it or ..."
std::string why_refused(const End& end) {
  const std::string did = end.late                  ? "takes too long "
                          : WIFSIGNALED(end.status) ? "crashes "
                                                    : "ends the process ";
  return did + end.phase + " (" + how_it_ended(end) + "): mend it or take another plugin";
}

bool was_interrupted(int status) {
  constexpr std::array kByTheUser = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
  return WIFSIGNALED(status) &&
         std::find(kByTheUser.begin(), kByTheUser.end(), WTERMSIG(status)) != kByTheUser.end();
}

/// Result if no plugin's code was running: a plugin may have damaged memory earlier, or Skybody has
/// a bug.
ChildOutput unexplained(const End& end) {
  return {
      kExitBug, "",
      "internal error: the process that opened plugins has ended early (" + how_it_ended(end) +
          ")" +
          (end.file.empty() ? "\n" : "; a plugin that it opened may have damaged its memory\n")};
}

/// Ends this process by the signal that ended the child, after an interruption by the user.
[[noreturn]] void follow(int status) {
  signal(WTERMSIG(status), SIG_DFL);
  raise(WTERMSIG(status));
  _exit(kExitSignal + WTERMSIG(status));  // not reached: the signal ends the process
}

}  // namespace

ChildOutput output_of_child(const Work& work, unsigned patience) {
  RefusedFiles refused;
  while (true) {
    End end = run_child(work, refused, patience);
    if (end.done && WIFEXITED(end.status)) {
      return {WEXITSTATUS(end.status), std::move(end.out), std::move(end.err)};
    }
    // An interruption by the user reaches this process as well; a signal raised by a plugin is the
    // plugin's error.
    if (end.phase.empty() && was_interrupted(end.status)) follow(end.status);
    const bool is_new = !end.phase.empty() && refused.emplace(end.file, why_refused(end)).second;
    if (!is_new) return unexplained(end);
  }
}

int run_in_child(const Work& work) {
  const ChildOutput output = output_of_child(work);
  std::fwrite(output.err.data(), 1, output.err.size(), stderr);
  print(output.out);
  return output.status;
}

}  // namespace skybody
