#include "tests/integration/flips.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <ostream>
#include <random>
#include <vector>

#include "core/base/system/error.h"

namespace skybody::test {
namespace {

constexpr unsigned kSeconds = 10;  // reading takes milliseconds

enum Exit { kRefused, kSame, kDifferent, kThrew };

[[noreturn]] void read_and_exit(const std::string& whole,
                                const std::function<std::string()>& read) {
  alarm(kSeconds);
  try {
    _exit(read() == whole ? kSame : kDifferent);
  } catch (const Error&) {
    _exit(kRefused);
  } catch (...) {
    _exit(kThrew);
  }
}

void count_end(int status, FlipCounts& counts) {
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code == kRefused) {
    ++counts.refused;
  } else if (code == kSame) {
    ++counts.same;
  } else if (code == kDifferent) {
    ++counts.different;
  } else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) {
    ++counts.hung;
  } else {
    ++counts.crashed;
  }
}

/// Indices of non-zero bytes and their neighbours. HDF5 reserves space that no reader uses.
std::vector<std::size_t> used_bytes(const std::string& bytes) {
  constexpr std::size_t kNear = 16;
  std::vector<std::size_t> used;
  std::size_t zeros = bytes.size();  // since the last non-zero byte
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    zeros = bytes[k] != 0 ? 0 : zeros + 1;
    if (zeros <= kNear) used.push_back(k);
  }
  return used;
}

void put(const std::filesystem::path& file, std::size_t at, char byte) {
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  stream.seekp(static_cast<std::streamoff>(at));
  stream.put(byte);
}

}  // namespace

void PrintTo(const FlipCounts& c, std::ostream* out) {
  *out << c.refused << " refused, " << c.same << " the same, " << c.different << " different, "
       << c.crashed << " crashed, " << c.hung << " hung";
}

int flips_wanted(int usual) {
  const char* wanted = std::getenv("SKYBODY_FLIPS");
  return wanted == nullptr ? usual : std::atoi(wanted);
}

FlipCounts flip_bits(const std::filesystem::path& file, int flips,
                     const std::function<std::string()>& read) {
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const std::string whole = read();
  const std::vector<std::size_t> used = used_bytes(bytes);
  const std::size_t bits = used.size() * 8;
  std::mt19937_64 random(1);
  FlipCounts counts;
  const bool all = static_cast<std::size_t>(flips) >= bits;
  for (std::size_t k = 0; k < (all ? bits : static_cast<std::size_t>(flips)); ++k) {
    const std::size_t place = all ? k : random() % bits, bit = used[place / 8] * 8 + place % 8;
    put(file, bit / 8, static_cast<char>(bytes[bit / 8] ^ (1 << bit % 8)));
    const pid_t child = fork();
    if (child == 0) read_and_exit(whole, read);
    int status = 0;
    waitpid(child, &status, 0);
    const FlipCounts before = counts;
    count_end(status, counts);
    if (counts.crashed + counts.hung + counts.different >
        before.crashed + before.hung + before.different) {
      std::printf("bit %zu of byte %zu: status %d\n", bit % 8, bit / 8, status);
    }
    put(file, bit / 8, bytes[bit / 8]);
  }
  return counts;
}

}  // namespace skybody::test
