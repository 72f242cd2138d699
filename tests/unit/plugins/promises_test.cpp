// What libraries promise by their names and sidecars.
#include "plugins/host/promises.h"

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
  const auto files = promising_files(folder.path());
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
  const auto files = promising_files(folder.path());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0].sidecar, folder.path() / "weather.plugins");
  EXPECT_THAT(files[0].names, ElementsAre("wind", "gust", "rain"));
}

TEST(Promises, OfAMissingFolderAreNone) { EXPECT_TRUE(promising_files("/no/such/folder").empty()); }

}  // namespace
}  // namespace skybody
