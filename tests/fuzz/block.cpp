#include "tests/fuzz/block.h"

#include <cxxabi.h>
#include <execinfo.h>
#include <malloc.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <new>
#include <typeinfo>
#include <vector>

namespace skybody::fuzz {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized =
    true;  // it reserves terabytes, catches signals, and detects leaks itself
#else
constexpr bool kSanitized = false;
#endif

/// One in this many inputs is run thoroughly.
constexpr std::uint64_t kThorough = 16;
/// Repetitions of a leak check, and the first ones to ignore: malloc's caches count as used memory
/// and settle after a few repetitions.
constexpr int kRepetitions = 7, kSettling = 3;
/// Repetitions that confirm a suspected leak: malloc keeps up to seven freed blocks of each size,
/// and they appear to be in use.
constexpr int kConfirmations = 24;

std::uint64_t processor_ns() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000u +
         static_cast<std::uint64_t>(time.tv_nsec);
}

std::string type_name(const std::exception& error) {
  int failed = 0;
  char* name = abi::__cxa_demangle(typeid(error).name(), nullptr, nullptr, &failed);
  const std::string text = failed == 0 ? name : typeid(error).name();
  free(name);
  return text;
}

/// Runs one input. @returns false after a finding
bool run_one(const Block& block, std::uint64_t k, Progress& progress) {
  const bool thorough = block.only_accepted || k % kThorough == 0;
  try {
    const Answer answer = block.area->run(block.inputs->make(k), thorough);
    ++(answer == Answer::kAccepted ? progress.accepted : progress.refused);
    if (!block.only_accepted || answer == Answer::kAccepted) return true;
    progress.note(FindingKind::kWrongAnswer, "a valid input is refused");
  } catch (const Finding& finding) {
    progress.note(finding.kind(), finding.what());
  } catch (const std::bad_alloc&) {
    progress.note(FindingKind::kMemory, "asks for more memory than it may have");
  } catch (const std::exception& error) {
    progress.note(FindingKind::kWrongAnswer, type_name(error) + ": " + error.what());
  }
  return false;
}

bool run_timed(const Block& block, std::uint64_t k, Progress& progress) {
  progress.input = k;
  ++progress.starts;
  const std::uint64_t before = processor_ns();
  if (!run_one(block, k, progress)) return false;
  const std::uint64_t time = processor_ns() - before;
  if (time > progress.slowest_ns) {
    progress.slowest_ns = time;
    progress.slowest_input = k;
  }
  return true;
}

/// Runs an input again without counting it.
void run_again(const Block& block, std::uint64_t k, Progress& progress) {
  const std::uint64_t refused = progress.refused, accepted = progress.accepted;
  progress.input = k;
  ++progress.starts;
  run_one(block, k, progress);
  progress.refused = refused;
  progress.accepted = accepted;
}

std::size_t heap_in_use() { return mallinfo2().uordblks; }

/// Growth of the heap while `count` inputs are run again: the minimum over the repetitions.
std::size_t growth(const Block& block, std::uint64_t first, std::uint64_t count, int repetitions,
                   Progress& progress) {
  std::size_t least = ~std::size_t{0};
  for (int repetition = 0; repetition < repetitions && least > 0; ++repetition) {
    const std::size_t before = heap_in_use();
    for (std::uint64_t k = first; k < first + count; ++k) run_again(block, k, progress);
    const std::size_t after = heap_in_use();
    if (repetition < kSettling) continue;
    least = std::min(least, after > before ? after - before : 0);
  }
  return least;
}

void look_for_leaks(const Block& block, std::uint64_t count, Progress& progress) {
  const std::size_t smallest = block.area->smallest_leak();
  if (kSanitized || smallest == 0 || count == 0) return;
  progress.repeating = true;
  const std::uint64_t again = std::min(count, kLeakInputs);
  if (growth(block, block.first, again, kRepetitions, progress) < smallest) return;
  std::size_t most = 0;
  std::uint64_t worst = block.first;
  for (std::uint64_t k = block.first; k < block.first + again; ++k) {
    const std::size_t bytes = growth(block, k, 1, kRepetitions, progress);
    if (bytes <= most) continue;
    most = bytes;
    worst = k;
  }
  if (most > 0) most = growth(block, worst, 1, kConfirmations, progress);
  if (most == 0) return;  // a list that grew occasionally
  progress.input = worst;
  progress.note(FindingKind::kLeak, std::to_string(most) + " bytes each time it is run");
}

Progress* crashed_progress = nullptr;

/// Records addresses only; the parent process, which has the same libraries at the same addresses,
/// resolves the names.
void note_crash(int signal) {
  crashed_progress->frame_count =
      backtrace(crashed_progress->frames.data(), static_cast<int>(Progress::kFrames));
  ::signal(signal, SIG_DFL);
  raise(signal);
}

void catch_crashes(Progress& progress) {
  if (kSanitized) return;
  crashed_progress = &progress;
  void* first[1];
  backtrace(first, 1);  // loads the libraries it needs
  static std::vector<char> stack(1 << 16);
  const stack_t own{stack.data(), 0, stack.size()};
  sigaltstack(&own, nullptr);
  struct sigaction action {};
  action.sa_handler = note_crash;
  action.sa_flags = SA_ONSTACK | SA_NODEFER;
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
    sigaction(number, &action, nullptr);
  }
}

}  // namespace

void run_block(const Block& block, const std::filesystem::path& folder, Progress& progress) {
  block.area->begin(folder);
  std::uint64_t done = 0;
  while (done < block.count && !progress.stop && run_timed(block, block.first + done, progress)) {
    ++done;
  }
  if (!progress.has_finding) look_for_leaks(block, done, progress);
  progress.finished = true;
}

void guard_process(const Limits& limits, Progress& progress) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit memory{limits.memory, limits.memory};
  if (!kSanitized) setrlimit(RLIMIT_DATA, &memory);
  catch_crashes(progress);
}

}  // namespace skybody::fuzz
