// Plugins that end, or never end, the child process that opens them.
#include "app/plugin_child.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "core/base/system/plugin_call_trace.h"

namespace skybody {
namespace {

/// Prints the reasons for refused files, or calls the plugin's code, if any, `in configure()`.
template <class Code>
ChildOutput output_with(const Code& code, unsigned patience = kPluginTimeout) {
  return output_of_child(
      [&code](const RefusedFiles& refused) {
        for (const auto& [file, why] : refused) std::printf("%s: %s\n", file.c_str(), why.c_str());
        if (!refused.empty()) return 0;
        const PluginPhase phase("/lab/law.so", "in configure()");
        code();
        return 0;
      },
      patience);
}

void block_everything_and_loop() {
  sigset_t all;
  sigfillset(&all);
  sigprocmask(SIG_BLOCK, &all, nullptr);
  const volatile bool forever = true;
  while (forever) {
  }
}

TEST(PluginChild, GivesWhatIsWritten) {
  const ChildOutput output = output_with([] { std::printf("all is well"); });
  EXPECT_EQ(output.status, 0);
  EXPECT_EQ(output.out, "all is well");
}

TEST(PluginChild, RefusesAPluginThatBlocksEverySignalAndLoops) {
  const ChildOutput output = output_with(block_everything_and_loop, 1);
  EXPECT_EQ(output.status, 0);
  EXPECT_EQ(output.out,
            "/lab/law.so: takes too long in configure() (signal 9, Killed): mend it or take "
            "another plugin\n");
}

/// Each phase is shorter than the time limit, all together are longer.
TEST(PluginChild, IsPatientWithEachPhase) {
  const ChildOutput output = output_of_child(
      [](const RefusedFiles& refused) {
        for (int i = 0; i < 150; ++i) {
          const PluginPhase phase("/lab/law.so", "in configure()");
          usleep(10000);
        }
        return static_cast<int>(refused.size());
      },
      1);
  EXPECT_EQ(output.status, 0);
}

TEST(PluginChild, TakesAPluginsSignalForThePlugins) {
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) {
    const ChildOutput output = output_with([number] { kill(getpid(), number); });
    EXPECT_EQ(output.status, 0);
    EXPECT_THAT(output.out, testing::StartsWith("/lab/law.so: crashes in configure() (signal " +
                                                std::to_string(number)));
  }
}

}  // namespace
}  // namespace skybody
