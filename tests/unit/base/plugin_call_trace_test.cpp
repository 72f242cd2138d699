// Information for a watcher after a plugin has ended the process.
#include "core/base/system/plugin_call_trace.h"

#include <gtest/gtest.h>

namespace skybody {
namespace {

TEST(PluginCallTrace, NamesTheFileAndThePhaseWhileTheyLast) {
  PluginCallTrace found{};
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

TEST(PluginCallTrace, CountsPhases) {
  PluginCallTrace found{};
  watch_plugins(&found);
  { const PluginPhase phase("/lab/law.so", "in configure()"); }
  { const PluginPhase phase("/lab/law.so", "in configure()"); }
  watch_plugins(nullptr);
  EXPECT_EQ(found.phases, 2u);
}

}  // namespace
}  // namespace skybody
