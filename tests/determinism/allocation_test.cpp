// No allocation of ours in the step path: operator new is replaced, and every call that comes from
// libskybody or a plugin while stepping is counted. Simbody's own allocations (13 a step in the
// air) come from its libraries and are not; without Simbody there is none at all.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <vector>

#include "core/assemble/hold_policy.h"
#include "core/assemble/simulation.h"
#include "core/physics/free_body_dynamics.h"

namespace {

std::atomic<bool> counting{false};
std::atomic<int> ours_counted{0}, all_counted{0};

bool is_ours(void* caller) {
  Dl_info info;
  if (dladdr(caller, &info) == 0 || info.dli_fname == nullptr) return false;
  const char* name = std::strrchr(info.dli_fname, '/');
  name = name == nullptr ? info.dli_fname : name + 1;
  return std::strncmp(name, "libskybody", 10) == 0 ||
         std::strstr(info.dli_fname, "skybody/plugins/") != nullptr;
}

[[gnu::noinline]] void note(void* caller) {
  if (!counting.load()) return;
  counting.store(false);  // dladdr must not count itself
  ++all_counted;
  if (is_ours(caller)) ++ours_counted;
  counting.store(true);
}

}  // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
  note(__builtin_return_address(0));
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new[](std::size_t size) {
  note(__builtin_return_address(0));
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p, std::size_t) noexcept { std::free(p); }

namespace skybody {
namespace {

class NoAllocation : public testing::TestWithParam<const char*> {};

TEST_P(NoAllocation, OfOursHappensWhileStepping) {
  Simulation simulation({.scenario = SKYBODY_SOURCE_DIR "/scenarios/" + std::string(GetParam())});
  const HoldPolicy hold(simulation.environment());
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  simulation.reset();
  hold.act(simulation, action);
  for (int i = 0; i < 10; ++i) simulation.step(action);  // caches fill
  ours_counted = all_counted = 0;
  for (int i = 0; i < 50; ++i) {
    hold.act(simulation, action);  // a baseline may allocate
    counting = true;
    simulation.step(action);
    counting = false;
  }
  EXPECT_EQ(ours_counted.load(), 0) << "of " << all_counted.load() << " in all";
  const bool simbody = !why_not_tree(simulation.environment().world()).empty();
  EXPECT_EQ(all_counted.load() > 0, simbody) << all_counted.load();
}

TEST(Allocation, IsCounted) {
  all_counted = 0;
  counting = true;
  const std::vector<float> some(100);
  counting = false;
  EXPECT_EQ(all_counted.load(), 1) << "is operator new still replaced? " << some.size();
}

INSTANTIATE_TEST_SUITE_P(Scenarios, NoAllocation,
                         testing::Values("hover.yaml", "payload.yaml", "formation.yaml"));

}  // namespace
}  // namespace skybody
