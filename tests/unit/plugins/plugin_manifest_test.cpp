// Declarations of libraries by their names and sidecar files.
#include "core/plugin_host/plugin_manifest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

using testing::ElementsAre;

TEST(Promises, AreTheFileNameWithoutASidecar) {
  const test::Folder folder;
  std::ofstream(folder.path() / "wind.so");
  std::ofstream(folder.path() / "notes.txt");
  std::filesystem::create_directory(folder.path() / "folder.so");
  const auto files = plugin_manifests(folder.path());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0].file, folder.path() / "wind.so");
  EXPECT_EQ(files[0].sidecar, "");
  EXPECT_THAT(files[0].names, ElementsAre("wind"));
  EXPECT_TRUE(files[0].promises("wind"));
  EXPECT_FALSE(files[0].promises("win"));
}

TEST(Promises, AreTheLinesOfASidecar) {
  const test::Folder folder;
  std::ofstream(folder.path() / "weather.so");
  std::ofstream(folder.path() / "weather.plugins")
      << "# of the lab\n wind \r\n\ngust # strong\nrain";
  const auto files = plugin_manifests(folder.path());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0].sidecar, folder.path() / "weather.plugins");
  EXPECT_THAT(files[0].names, ElementsAre("wind", "gust", "rain"));
}

TEST(Promises, OfALongSidecarAreAProblem) {
  const test::Folder folder;
  std::ofstream(folder.path() / "weather.so");
  std::ofstream(folder.path() / "weather.plugins") << "wind\n" << std::string(65536, '#');
  const auto files = plugin_manifests(folder.path());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0].problem, "its list of plugins " +
                                  (folder.path() / "weather.plugins").string() +
                                  " has more than 65536 bytes, which no list has; write one name a "
                                  "line");
  EXPECT_TRUE(files[0].promises("wind"));
  EXPECT_TRUE(files[0].promises("weather"));
}

TEST(Promises, OfAFolderThatCannotBeReadAreAProblem) {
  const std::string name(300, 'x');  // longer than the names of any file system
  EXPECT_EQ(folder_problem("/" + name), "/" + name +
                                            ": this folder of plugins cannot be read: File name "
                                            "too long; make it readable or leave it out");
  EXPECT_EQ(folder_problem("/no/such/folder"), "");
  EXPECT_EQ(folder_problem("/tmp"), "");
}

TEST(Promises, OfAMissingFolderAreNone) {
  EXPECT_TRUE(plugin_manifests("/no/such/folder").empty());
}

}  // namespace
}  // namespace skybody
