// Advice in messages: files that do not exist, included files, numbers with units.
#include <gtest/gtest.h>

#include "core/io/files/missing_file.h"
#include "core/io/files/unit_hint.h"
#include "core/io/yaml/include_chain.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

TEST(MissingFile, NamesAFileOfASimilarName) {
  const TempFolder folder;
  const std::string there = folder.write("models/quad/quad.urdf", "");
  folder.write("models/quad/quad.stl", "");
  EXPECT_EQ(similar_file(folder.path("modles/quad/qaud.urdf")), there);
  EXPECT_EQ(similar_file(folder.path("models/quad/octo.urdf")), "");
  EXPECT_EQ(similar_file(folder.path("models/quad/quad.yaml")), "") << "another kind of file";
  EXPECT_EQ(missing_file(folder.path("models/quad/qua.urdf"), "look elsewhere"),
            "the file `" + folder.path("models/quad/qua.urdf") +
                "` does not exist; did you mean `" + there + "`?");
}

TEST(MissingFile, NamesTheRemedyWithoutASimilarName) {
  const TempFolder folder;
  const std::string gone = folder.path("gone.yaml");
  EXPECT_EQ(missing_file(gone, "look elsewhere", {"hover"}),
            "the file `" + gone + "` does not exist; look elsewhere");
  EXPECT_EQ(missing_file(gone, "look elsewhere", {"gne"}),
            "the file `" + gone + "` does not exist; did you mean `gne`?");
}

TEST(MissingFile, IsSilentOnFilesAndFoldersThatExist) {
  const TempFolder folder;
  EXPECT_EQ(missing_file(folder.write("here.yaml", ""), "look elsewhere"), "");
  EXPECT_EQ(missing_file(folder.path(""), "look elsewhere"), "");
}

TEST(MissingFile, FindsSimilarNamesInLargeFolders) {
  const TempFolder folder;
  for (int k = 0; k < 300; ++k) folder.write("a_longer_name_" + std::to_string(k) + ".yaml", "");
  const std::string there = folder.write("base.yaml", "");
  EXPECT_EQ(similar_file(folder.path("bse.yaml")), there);
}

TEST(UnitHint, ConvertsUnitsOfTheSameKind) {
  EXPECT_EQ(unit_hint("1ms", "s"), "; do you mean 0.001?");
  EXPECT_EQ(unit_hint("-2.5 cm", "m"), "; do you mean -0.025?");
  EXPECT_EQ(unit_hint("90deg", "rad"), "; do you mean 1.5708?");
  EXPECT_EQ(unit_hint("3e2 g", "kg"), "; do you mean 0.3?");
  EXPECT_EQ(unit_hint("2 kg", "kg"), "; do you mean 2?");
}

TEST(UnitHint, AdvisesToLeaveOtherUnitsOut) {
  const std::string without = "; write the number without a unit";
  EXPECT_EQ(unit_hint("200 Hz", "s"), without);
  EXPECT_EQ(unit_hint("1 ms", "m"), without);
  EXPECT_EQ(unit_hint("5%", ""), without);
}

TEST(UnitHint, IsSilentOnOtherTexts) {
  for (const char* text : {"", "fast", "1,2,3", "1", "ms", "1 2", "nan", "-"}) {
    EXPECT_EQ(unit_hint(text, "s"), "") << text;
  }
}

TEST(IncludeChain, ListsTheNearestFileFirst) {
  const TempFolder folder;
  const std::string root = folder.write("root.yaml", "include: [a.yaml, b.yaml]\n");
  const std::string a = folder.write("a.yaml", "include: deep/c.yaml\n");
  const std::string b = folder.write("b.yaml", "task: {}\n");
  const std::string c = folder.write("deep/c.yaml", "include: ../a.yaml\n");
  EXPECT_EQ(included_files(root), (std::vector<std::string>{b, a, c}));
}

TEST(IncludeChain, TakesFilesThatCannotBeReadAsOnesWithoutIncludes) {
  const TempFolder folder;
  const std::string bad = folder.write("bad.yaml", "a: [1\n");
  const std::string root = folder.write("root.yaml", "include: [gone.yaml, bad.yaml]\n");
  EXPECT_EQ(included_files(root), (std::vector<std::string>{bad, folder.path("gone.yaml")}));
  EXPECT_TRUE(included_files(bad).empty());
}

TEST(IncludeChain, PresetsAreThoseOfTheNearestFile) {
  const TempFolder folder;
  const std::string root = folder.write("root.yaml", "include: middle.yaml\n");
  folder.write("middle.yaml", "include: far/base.yaml\n");
  folder.write("far/base.yaml", "task: {}\n");
  EXPECT_EQ(training_presets(root), folder.path("training/root.yaml")) << "where they would be";
  const std::string base = folder.write("far/training/base.yaml", "gradient: {}\n");
  EXPECT_EQ(training_presets(root), base);
  const std::string middle = folder.write("training/middle.yaml", "gradient: {}\n");
  EXPECT_EQ(training_presets(root), middle);
  const std::string own = folder.write("training/root.yaml", "gradient: {}\n");
  EXPECT_EQ(training_presets(root), own);
}

}  // namespace
}  // namespace skybody
