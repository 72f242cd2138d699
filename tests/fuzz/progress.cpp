#include "tests/fuzz/progress.h"

#include <sys/mman.h>

#include <algorithm>
#include <new>
#include <stdexcept>

namespace skybody::fuzz {

Progress* Progress::make() {
  void* memory =
      mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no shared memory");
  return new (memory) Progress{};
}

void Progress::clear() {
  input = 0;
  starts = 0;
  stop = false;
  refused = accepted = slowest_ns = slowest_input = 0;
  repeating = finished = has_finding = false;
  text[0] = '\0';
  frame_count = 0;
}

void Progress::note(FindingKind finding, const std::string& what) {
  kind = finding;
  const std::size_t size = std::min(what.size(), text.size() - 1);
  std::copy_n(what.begin(), size, text.begin());
  text[size] = '\0';
  has_finding = true;
}

}  // namespace skybody::fuzz
