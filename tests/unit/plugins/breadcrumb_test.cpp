// What a watcher finds where a plugin has ended the process, or does not return.
#include "plugins/host/breadcrumb.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <string>

namespace skybody {
namespace {

TEST(Breadcrumb, NamesTheFileAndThePhaseWhileTheyLast) {
  Breadcrumb found{};
  watch_plugins(&found);
  {
    const PluginPhase phase("/lab/law.so", "in configure()");
    EXPECT_STREQ(found.file, "/lab/law.so");
    EXPECT_STREQ(found.phase, "in configure()");
  }
  EXPECT_STREQ(found.phase, "");
  watch_plugins(nullptr);
  const PluginPhase unseen("/lab/other.so", "in configure()");
  EXPECT_STREQ(found.file, "/lab/law.so");
}

void never_return() {
  Breadcrumb found{};
  watch_plugins(&found, 1);
  const PluginPhase phase("/lab/law.so", "in configure()");
  while (true) pause();
}

TEST(Breadcrumb, EndsTheProcessWhereAPhaseTakesTooLong) {
  EXPECT_EXIT(never_return(), testing::KilledBySignal(SIGALRM), "");
}

TEST(Breadcrumb, LeavesTheProcessAloneAfterThePhase) {
  Breadcrumb found{};
  watch_plugins(&found, 1);
  { const PluginPhase phase("/lab/law.so", "in configure()"); }
  EXPECT_EQ(alarm(0), 0u);  // none is set
  watch_plugins(nullptr);
}

}  // namespace
}  // namespace skybody
