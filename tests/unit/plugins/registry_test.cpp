// Plugins found on a search path, and problems that do not stop the search.
#include "core/plugin_host/registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <fstream>
#include <thread>

#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

using std::filesystem::path;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(PluginRegistry, ListsPluginsByKind) {
  const PluginRegistry registry({"/no/such/folder", test::good_plugins()});
  registry.open_all();
  EXPECT_THAT(registry.names(SKYBODY_CONTROLLER),
              ElementsAre("flush_to_zero", "lane_controller", "plain_controller",
                          "spoilt_reference", "throws_error", "throws_int"));
  EXPECT_THAT(registry.names(SKYBODY_SENSOR), ElementsAre("delay_sensor", "feeling_sensor"));
  EXPECT_THAT(registry.names(SKYBODY_RANDOMIZER), ElementsAre("lane_randomizer"));
  EXPECT_THAT(registry.names(SKYBODY_TASK), ElementsAre("lane_task"));
  EXPECT_EQ(registry.find(SKYBODY_SENSOR, "lane_task"), nullptr);
}

TEST(PluginRegistry, NamesOfAClosedLibraryAreOfNoKindYet) {
  const PluginRegistry registry({test::good_plugins()});
  EXPECT_TRUE(registry.names(SKYBODY_CONTROLLER).empty());
  EXPECT_THAT(registry.promised(), Contains("lane_controller"));
  ASSERT_NE(registry.find(SKYBODY_CONTROLLER, "lane_controller"), nullptr);
  EXPECT_THAT(registry.names(SKYBODY_CONTROLLER), ElementsAre("lane_controller"));
  EXPECT_THAT(registry.promised(), Not(Contains("lane_controller")));
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
    EXPECT_THAT(entry->failure, HasSubstr("was built for plugin API 9"));
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

/// True if the plugin `leaves_a_mark` has been loaded since the construction.
class Mark {
 public:
  Mark() : file_(folder_.path() / "mark") { setenv("SKYBODY_TEST_MARK", file_.c_str(), 1); }
  ~Mark() { unsetenv("SKYBODY_TEST_MARK"); }
  bool is_there() const { return std::filesystem::exists(file_); }

 private:
  test::Folder folder_;
  path file_;
};

/// A folder with `leaves_a_mark` under another name.
class Marked : public testing::Test {
 protected:
  void put(const std::string& name) {
    std::filesystem::copy_file(test::hostile_plugins() / "leaves_a_mark.so", folder.path() / name);
  }
  const Mark mark;
  const test::Folder folder;
};

TEST_F(Marked, IsOpenedOnlyWhereItIsNamed) {
  put("leaves_a_mark.so");
  const PluginRegistry registry({folder.path(), test::good_plugins()});
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "lane_controller")->failure, "");
  // Its kind is unknown before it is opened.
  EXPECT_THAT(registry.names(SKYBODY_SENSOR), Not(Contains("leaves_a_mark")));
  EXPECT_FALSE(mark.is_there());
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "leaves_a_mark")->failure, "");
  EXPECT_TRUE(mark.is_there());
}

TEST_F(Marked, IsNotOpenedWhereEverybodyMayWrite) {
  put("leaves_a_mark.so");
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  const PluginRegistry registry({folder.path()});
  EXPECT_THAT(registry.find(SKYBODY_CONTROLLER, "leaves_a_mark")->failure,
              HasSubstr("leaves_a_mark.so: is not opened: everybody may write its folder "));
  EXPECT_EQ(registry.open_all().size(), 1u);
  EXPECT_FALSE(mark.is_there());
}

TEST_F(Marked, IsNotOpenedThroughALinkThatEverybodyMayWrite) {
  const test::Folder links;
  std::filesystem::create_symlink(test::hostile_plugins() / "leaves_a_mark.so",
                                  links.path() / "lane_controller.so");
  std::filesystem::permissions(links.path(), std::filesystem::perms::all);
  const PluginRegistry registry({links.path()});
  EXPECT_THAT(registry.find(SKYBODY_CONTROLLER, "lane_controller")->failure,
              HasSubstr("everybody may write its folder " + links.path().string()));
  EXPECT_FALSE(mark.is_there());
}

TEST_F(Marked, MustHoldWhatItsNamePromises) {
  put("wind.so");
  const PluginRegistry registry({folder.path()});
  const std::string file = (folder.path() / "wind.so").string();
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "leaves_a_mark"), nullptr);
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "wind")->failure,
            file +
                ": promises a plugin `wind`, but holds controller `leaves_a_mark`: write the names "
                "of its "
                "plugins into " +
                (folder.path() / "wind.plugins").string() + ", one a line");
}

TEST_F(Marked, IsFoundByItsSidecar) {
  put("wind.so");
  std::ofstream(folder.path() / "wind.plugins") << "leaves_a_mark\n";
  const PluginRegistry registry({folder.path()});
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "wind"), nullptr);
  EXPECT_FALSE(mark.is_there());
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "leaves_a_mark")->failure, "");
}

TEST_F(Marked, MustHoldWhatItsSidecarPromises) {
  put("wind.so");
  std::ofstream(folder.path() / "wind.plugins") << "leaves_a_mark\ngust\n";
  const PluginRegistry registry({folder.path()});
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "leaves_a_mark")->failure, "");
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "gust")->failure,
            (folder.path() / "wind.so").string() +
                ": promises a plugin `gust`, but holds controller `leaves_a_mark`: mend " +
                (folder.path() / "wind.plugins").string());
}

TEST_F(Marked, MustBePromisedByASidecarToBeUsed) {
  put("wind.so");
  std::ofstream(folder.path() / "wind.plugins") << "# nothing yet\n";
  const PluginRegistry registry({folder.path()});
  ASSERT_EQ(registry.open_all().size(), 1u);
  EXPECT_EQ(registry.open_all()[0]->failure,
            (folder.path() / "wind.so").string() +
                ": holds controller `leaves_a_mark`, which it does not promise: mend " +
                (folder.path() / "wind.plugins").string());
}

TEST_F(Marked, IsNotOpenedWhereItsSidecarIsTooLong) {
  put("wind.so");
  std::ofstream(folder.path() / "wind.plugins") << "leaves_a_mark\n" << std::string(65536, '#');
  const PluginRegistry registry({folder.path()});
  EXPECT_THAT(registry.find(SKYBODY_CONTROLLER, "leaves_a_mark")->failure,
              HasSubstr("wind.plugins has more than 65536 bytes"));
  EXPECT_FALSE(mark.is_there());
}

TEST(PluginRegistry, ListsAFolderThatCannotBeRead) {
  const path folder = "/" + std::string(300, 'x');  // longer than the names of any file system
  const PluginRegistry registry({folder});
  ASSERT_EQ(registry.open_all().size(), 1u);
  EXPECT_THAT(registry.open_all()[0]->failure, HasSubstr("cannot be read"));
}

/// It could become an unchecked library at any moment.
TEST_F(Marked, IsRefusedAsAPipeWithoutBeingOpened) {
  const path pipe = folder.path() / "wind.so";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  const PluginRegistry registry({folder.path()});
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "wind")->failure,
            pipe.string() + ": is no regular file, but a device, a pipe or a folder");
}

TEST(PluginRegistry, ATwinsFailureDoesNotChangeWhileOthersReadIt) {
  const PluginRegistry registry({test::twin_plugins()});
  std::vector<std::string> failures(8);
  std::vector<std::thread> threads;
  for (std::string& failure : failures) {
    threads.emplace_back([&] {
      for (int i = 0; i < 100; ++i) failure = registry.find(SKYBODY_CONTROLLER, "twin")->failure;
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& failure : failures) EXPECT_THAT(failure, HasSubstr("two plugins"));
}

/// The remedy for a file that others may write would be wrong for a device.
TEST(PluginRegistry, RefusesDevicesAsSuch) {
  const test::Folder folder;
  std::filesystem::create_symlink("/dev/zero", folder.path() / "zero.so");
  const PluginRegistry registry({folder.path()});
  EXPECT_EQ(registry.find(SKYBODY_TASK, "zero")->failure,
            "/dev/zero: is no regular file, but a device, a pipe or a folder");
}

TEST(PluginRegistry, ListsABrokenFileThatPromisesNothing) {
  const test::Folder folder;
  std::ofstream(folder.path() / "wind.so") << "no library";
  std::ofstream(folder.path() / "wind.plugins");
  const PluginRegistry registry({folder.path()});
  ASSERT_EQ(registry.open_all().size(), 1u);
  EXPECT_EQ(registry.open_all()[0]->name, "wind");
  EXPECT_THAT(registry.open_all()[0]->failure, HasSubstr("cannot be loaded"));
}

TEST_F(Marked, IsNotOpenedWhenItIsRefused) {
  put("leaves_a_mark.so");
  const path file = folder.path() / "leaves_a_mark.so";
  const PluginRegistry registry({folder.path()}, {{file, "crashes while it is loaded"}});
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "leaves_a_mark")->failure,
            file.string() + ": crashes while it is loaded");
  EXPECT_FALSE(mark.is_there());
}

TEST_F(Marked, DoesNotMakeATwinWhereItIsNotTrusted) {
  put("lane_controller.so");
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  const PluginRegistry registry({folder.path(), test::good_plugins()});
  EXPECT_EQ(registry.find(SKYBODY_CONTROLLER, "lane_controller")->failure, "");
  EXPECT_FALSE(mark.is_there());
}

TEST(PluginRegistry, IsOpenedByManyThreadsOnceEach) {
  const PluginRegistry registry({test::good_plugins()});
  std::vector<const PluginEntry*> found(8);
  std::vector<std::thread> threads;
  for (const PluginEntry*& entry : found) {
    threads.emplace_back([&] { entry = registry.find(SKYBODY_CONTROLLER, "lane_controller"); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const PluginEntry* entry : found) EXPECT_EQ(entry, found[0]);
  EXPECT_EQ(found[0]->failure, "");
}

TEST(PluginRegistry, OneFileFoundTwiceIsFine) {
  const test::Folder folder;
  std::filesystem::create_symlink(std::filesystem::canonical(test::good_plugins() / "lane_task.so"),
                                  folder.path() / "lane_task.so");
  const PluginRegistry registry({test::good_plugins(), test::good_plugins() / "..", folder.path(),
                                 test::good_plugins() / ".." / "good"});
  EXPECT_EQ(registry.find(SKYBODY_TASK, "lane_task")->failure, "");
  registry.open_all();
  EXPECT_THAT(registry.names(SKYBODY_TASK), ElementsAre("lane_task"));
}

TEST(SearchPath, HasTheEnvironmentThenTheShippedOnes) {
  setenv("SKYBODY_PLUGIN_PATH", "/first:relative/second::", 1);
  const auto with = default_search_path();
  unsetenv("SKYBODY_PLUGIN_PATH");
  const auto without = default_search_path();
  EXPECT_THAT(with, ElementsAre(path("/first"), path("relative/second"), shipped_plugin_folder()));
  EXPECT_THAT(without, ElementsAre(shipped_plugin_folder()));
  EXPECT_THAT(shipped_plugin_folder().string(), HasSubstr("/skybody/plugins"));
}

TEST(SearchPath, OfAScenarioIsAbsoluteAlsoForABareName) {
  const path here = std::filesystem::current_path();
  EXPECT_THAT(scenario_plugin_folders("lab.yaml"), ElementsAre(here, here / "plugins"));
  EXPECT_THAT(scenario_plugin_folders("/lab/a.yaml"),
              ElementsAre(path("/lab"), path("/lab/plugins")));
}

}  // namespace
}  // namespace skybody
