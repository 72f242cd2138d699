// `skybody new`: names, all or nothing, no placeholders left.
#include "core/plugin_host/new_project.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "core/base/plugin_kind.h"
#include "core/base/system/error.h"
#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

using testing::HasSubstr;

std::string message(SkybodyKind kind, const std::string& name,
                    const std::filesystem::path& folder) {
  try {
    write_new_plugin_project(kind, name, folder);
  } catch (const Error& e) {
    return e.what();
  }
  return "was accepted";
}

std::set<std::string> files_of(const std::filesystem::path& folder) {
  std::set<std::string> files;
  for (const auto& item : std::filesystem::recursive_directory_iterator(folder)) {
    if (item.is_regular_file())
      files.insert(std::filesystem::relative(item.path(), folder).string());
  }
  return files;
}

TEST(NewProject, WritesACompleteFolderForEachKind) {
  const test::Folder folder;
  for (int k = 0; k < SKYBODY_KIND_COUNT; ++k) {
    const SkybodyKind kind = static_cast<SkybodyKind>(k);
    const std::string name = "my_" + std::string(kind_name(kind)) + "2";
    const auto project = write_new_plugin_project(kind, name, folder.path());
    EXPECT_EQ(project, folder.path() / name);
    EXPECT_EQ(files_of(project),
              (std::set<std::string>{".gitignore", "CMakeLists.txt", "README.md", name + ".cpp",
                                     "scenario.yaml", "tests/" + name + "_test.cpp"}));
    for (const std::string& file : files_of(project)) {
      std::ostringstream text;
      text << std::ifstream(project / file).rdbuf();
      for (const char* left : {"@NAME@", "@CLASS@", "@KIND@", "@A_KIND@"}) {
        EXPECT_EQ(text.str().find(left), std::string::npos) << file << " has " << left;
      }
      EXPECT_NE(text.str(), "") << file;
    }
  }
  for (const auto& item : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_THAT(item.path().filename().string(), HasSubstr("my_"));  // no temporary folder left
  }
}

TEST(NewProject, RefusesBadNames) {
  const test::Folder folder;
  for (const char* name : {"", "Wind", "2wind", "wind-gust", "wind gust", "_wind", "wind_",
                           "wi__nd", "../wind", "wind/gust"}) {
    EXPECT_EQ(message(SKYBODY_RANDOMIZER, name, folder.path()),
              "`" + std::string(name) +
                  "` cannot name a plugin; allowed: at most 64 lower-case letters, digits and "
                  "single underscores, a letter first, such as wind_gust");
  }
  EXPECT_EQ(message(SKYBODY_TASK, "random", folder.path()),
            "`random` is a word of Skybody or CMake; choose another, such as my_random");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(NewProject, OverwritesNothing) {
  const test::Folder folder;
  std::ofstream(folder.path() / "gust") << "mine";
  EXPECT_EQ(message(SKYBODY_SENSOR, "gust", folder.path()),
            (folder.path() / "gust").string() +
                " exists; nothing was written. Remove it or choose another name");
  std::filesystem::create_directory(folder.path() / "draught");
  EXPECT_THAT(message(SKYBODY_SENSOR, "draught", folder.path()), HasSubstr("exists"));
  EXPECT_EQ(files_of(folder.path()), std::set<std::string>{"gust"});
}

TEST(NewProject, NeedsAFolderToWriteTo) {
  EXPECT_EQ(message(SKYBODY_SENSOR, "gust", "/no/such/folder"),
            "there is no folder /no/such/folder");
}

}  // namespace
}  // namespace skybody
