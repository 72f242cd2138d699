// What is found on a search path, and what does not stop it.
#include "plugins/host/registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

using std::filesystem::path;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(PluginRegistry, ListsPluginsByKind) {
  const PluginRegistry registry({"/no/such/folder", test::good_plugins()});
  EXPECT_THAT(registry.names(SKYBODY_CONTROLLER),
              ElementsAre("flush_to_zero", "lane_controller", "plain_controller", "throws_error",
                          "throws_int"));
  EXPECT_THAT(registry.names(SKYBODY_SENSOR), ElementsAre("delay_sensor"));
  EXPECT_THAT(registry.names(SKYBODY_RANDOMIZER), ElementsAre("lane_randomizer"));
  EXPECT_THAT(registry.names(SKYBODY_TASK), ElementsAre("lane_task"));
  EXPECT_EQ(registry.find(SKYBODY_SENSOR, "lane_task"), nullptr);
}

TEST(PluginRegistry, ShowsWhatAPluginDeclares) {
  const PluginRegistry registry({test::good_plugins()});
  const PluginEntry* entry = registry.find(SKYBODY_CONTROLLER, "lane_controller");
  ASSERT_NE(entry, nullptr);
  EXPECT_EQ(entry->version, "1.0.0");
  EXPECT_EQ(entry->doc, "Filters rotor speeds in lanes.");
  EXPECT_EQ(entry->file.filename(), "lane_controller.so");
  EXPECT_TRUE(entry->vectorized);
  ASSERT_EQ(entry->parameters.size(), 3u);
  const ParameterSpec& tau = entry->parameters[0];
  EXPECT_EQ(tau.name, "tau");
  EXPECT_EQ(tau.unit, "s");
  EXPECT_EQ(tau.doc, "time constant");
  EXPECT_EQ(tau.min, 1e-6);
  EXPECT_EQ(tau.max, 10.0);
  EXPECT_TRUE(tau.is_scalar());
  EXPECT_THAT(tau.default_numbers, ElementsAre(0.02));
  EXPECT_FALSE(tau.randomizable);
  EXPECT_TRUE(entry->parameters[1].randomizable);
  EXPECT_FALSE(registry.find(SKYBODY_CONTROLLER, "plain_controller")->vectorized);
}

TEST(PluginRegistry, BrokenFilesBecomeEntriesAndStopNothing) {
  const PluginRegistry registry({test::bad_plugins(), test::good_plugins()});
  EXPECT_NE(registry.find(SKYBODY_CONTROLLER, "lane_controller"), nullptr);
  for (const SkybodyKind kind : {SKYBODY_CONTROLLER, SKYBODY_TASK}) {
    const PluginEntry* entry = registry.find(kind, "wrong_version");
    ASSERT_NE(entry, nullptr);
    EXPECT_EQ(entry->kind, SKYBODY_KIND_COUNT);
    EXPECT_THAT(entry->failure, HasSubstr("was built for plugin API 7"));
    EXPECT_EQ(entry->descriptor, nullptr);
  }
  EXPECT_THAT(registry.find(SKYBODY_SENSOR, "missing_symbol")->failure, HasSubstr("is no plugin"));
}

TEST(PluginRegistry, TwoFilesWithOnePluginMakeBothUnusable) {
  const PluginRegistry registry({test::twin_plugins()});
  const PluginEntry* entry = registry.find(SKYBODY_CONTROLLER, "twin");
  ASSERT_NE(entry, nullptr);
  const path folder = std::filesystem::canonical(test::twin_plugins());
  EXPECT_EQ(entry->failure, "two plugins of kind controller are called `twin`: " +
                                (folder / "twin_one.so").string() + " and " +
                                (folder / "twin_two.so").string() + "; remove or rename one");
  EXPECT_THAT(registry.names(SKYBODY_CONTROLLER), ElementsAre());
}

TEST(PluginRegistry, OneFileFoundTwiceIsFine) {
  const test::Folder folder;
  std::filesystem::create_symlink(std::filesystem::canonical(test::good_plugins() / "lane_task.so"),
                                  folder.path() / "another_name.so");
  const PluginRegistry registry({test::good_plugins(), test::good_plugins() / "..", folder.path(),
                                 test::good_plugins() / ".." / "good"});
  EXPECT_EQ(registry.find(SKYBODY_TASK, "lane_task")->failure, "");
  EXPECT_THAT(registry.names(SKYBODY_TASK), ElementsAre("lane_task"));
}

TEST(SearchPath, HasTheEnvironmentThenTheScenarioThenTheShippedOnes) {
  setenv("SKYBODY_PLUGIN_PATH", "/first:relative/second::", 1);
  const auto with = default_search_path("/lab/scenarios");
  unsetenv("SKYBODY_PLUGIN_PATH");
  const auto without = default_search_path("");
  EXPECT_THAT(with, ElementsAre(path("/first"), path("relative/second"), path("/lab/scenarios"),
                                path("/lab/scenarios/plugins"), shipped_plugin_folder()));
  EXPECT_THAT(without, ElementsAre(shipped_plugin_folder()));
  EXPECT_THAT(shipped_plugin_folder().string(), HasSubstr("/skybody/plugins"));
}

}  // namespace
}  // namespace skybody
