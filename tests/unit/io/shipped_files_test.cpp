// Shipped files are found by their names, whatever the folder of their task.
#include "core/io/files/shipped_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace skybody {
namespace {

using testing::Contains;
using testing::EndsWith;
using testing::Not;

std::string path(const std::optional<std::filesystem::path>& file) {
  return file ? file->string() : "none";
}

TEST(ShippedFiles, AScenarioIsInTheFolderOfItsTask) {
  EXPECT_THAT(path(find_shipped_scenario("hover")), EndsWith("scenarios/hover/hover.yaml"));
  EXPECT_THAT(path(find_shipped_scenario("arm")), EndsWith("scenarios/reach/arm.yaml"));
}

TEST(ShippedFiles, APolicyIsBesideItsScenario) {
  EXPECT_THAT(path(find_shipped_policy("racing_duel")),
              EndsWith("scenarios/racing/policies/racing_duel.h5"));
  EXPECT_EQ(find_shipped_policy("hover"), std::nullopt);
  for (const std::string& name : shipped_policies()) {
    EXPECT_EQ(find_shipped_policy(name)->parent_path().parent_path(),
              find_shipped_scenario(name)->parent_path());
  }
}

TEST(ShippedFiles, NamesAreThoseOfScenariosAlone) {
  const std::vector<std::string> names = shipped_scenarios();
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end()) << "one name, two files";
  EXPECT_THAT(names, Contains("hover_crazyflie"));
  EXPECT_THAT(names, Not(Contains("circle"))) << "a reference";
  EXPECT_EQ(find_shipped_scenario("circle"), std::nullopt);
  EXPECT_THAT(path(find_shipped_reference("circle")), EndsWith("scenarios/references/circle.yaml"));
}

TEST(ShippedFiles, AModelIsFoundByNameAndByThePathInScenarios) {
  const auto file = find_shipped_model("crazyflie");
  EXPECT_THAT(path(file), EndsWith("scenarios/models/crazyflie/crazyflie.urdf"));
  EXPECT_EQ(find_shipped_model("models/crazyflie/crazyflie.urdf"), file);
}

TEST(ShippedFiles, APathIsNoName) {
  for (const char* name : {"", "..", "hover/hover", "../hover/hover", "hover.yaml"}) {
    EXPECT_EQ(find_shipped_scenario(name), std::nullopt) << name;
  }
  for (const char* name : {"crazyflie/crazyflie.urdf", "models/crazyflie/../crazyflie.urdf",
                           "models/../models/crazyflie/crazyflie.urdf"}) {
    EXPECT_EQ(find_shipped_model(name), std::nullopt) << name;
  }
}

}  // namespace
}  // namespace skybody
