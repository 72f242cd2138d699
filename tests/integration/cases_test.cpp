// Every broken input of tests/bad_input/cases.yaml through the real program: the exact messages,
// the exit code, no crash, and nothing written into the working directory.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/config_tree.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;

struct Case {
  std::string name;
  std::vector<std::string> arguments;
  std::vector<std::string> stderr_lines;
  int exit_code = 2;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::vector<std::string> scalars(const ConfigNode& node) {
  std::vector<std::string> texts;
  for (const ConfigNode& item : node.items) texts.push_back(item.scalar);
  return texts;
}

std::vector<Case> read_cases() {
  Diagnostics diagnostics;
  const auto root = load_config(SKYBODY_SOURCE_DIR "/tests/bad_input/cases.yaml", diagnostics);
  diagnostics.throw_if_errors();
  std::vector<Case> cases;
  for (const ConfigNode& node : root->find("cases")->items) {
    cases.push_back({node.find("name")->scalar, scalars(*node.find("arguments")),
                     scalars(*node.find("stderr")), std::stoi(node.find("exit")->scalar)});
  }
  return cases;
}

/// A folder that looks like the project's root to paths below tests and scenarios.
void imitate_root(const fs::path& folder) {
  for (const char* name : {"tests", "scenarios"}) {
    fs::create_directory_symlink(fs::path(SKYBODY_SOURCE_DIR) / name, folder / name);
  }
}

class BadInput : public testing::TestWithParam<Case> {};

TEST_P(BadInput, GetsItsMessageAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  imitate_root(folder.path());
  const std::vector<std::string> before = folder.names();
  const Outcome outcome = run_skybody(GetParam().arguments, {.folder = folder.path()});
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.exit_code, GetParam().exit_code);
  EXPECT_EQ(lines_of(outcome.err), GetParam().stderr_lines);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(folder.names(), before);
}

INSTANTIATE_TEST_SUITE_P(Cases, BadInput, testing::ValuesIn(read_cases()),
                         [](const auto& test) { return test.param.name; });

TEST(BadInputCases, AreAtLeastThirtyFiles) { EXPECT_GE(read_cases().size(), 30u); }

}  // namespace
}  // namespace skybody::test
