// The bad inputs under tests/bad_input, read with a fake catalog: each gives exactly the messages
// of cases.yaml. (tests/integration runs the program itself, with exit codes, over the same table.)
#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/scenario_reader.h"
#include "tests/unit/io/fake_catalog.h"

namespace skybody {
namespace {

struct Case {
  std::string name;
  std::string file;
  std::vector<std::string> overrides;
  std::string messages;
};

/// Cases of `check` that need only the reader.
std::vector<Case> cases() {
  Diagnostics diagnostics;
  const auto table = load_config("tests/bad_input/cases.yaml", diagnostics);
  diagnostics.throw_if_errors();
  std::vector<Case> list;
  for (const ConfigNode& node : table->find("cases")->items) {
    const std::vector<ConfigNode>& arguments = node.find("arguments")->items;
    if (arguments.size() < 2 || arguments[0].scalar != "check" || node.find("needs") != nullptr) {
      continue;
    }
    Case c{node.find("name")->scalar, arguments[1].scalar, {}, ""};
    for (std::size_t i = 2; i + 1 < arguments.size(); i += 2) {
      c.overrides.push_back(arguments[i + 1].scalar);
    }
    for (const ConfigNode& line : node.find("stderr")->items) c.messages += line.scalar + '\n';
    list.push_back(std::move(c));
  }
  return list;
}

TEST(BadInput, EveryFileGetsExactlyItsMessages) {
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(SKYBODY_SOURCE_DIR);
  const FakeCatalog catalog;
  int count = 0;
  for (const Case& c : cases()) {
    Diagnostics diagnostics;
    EXPECT_FALSE(read_scenario(c.file, c.overrides, catalog, diagnostics).has_value()) << c.name;
    EXPECT_TRUE(diagnostics.has_errors()) << c.name;
    EXPECT_EQ(diagnostics.to_string(), c.messages) << c.name;
    ++count;
  }
  EXPECT_GE(count, 70);
  std::filesystem::current_path(before);
}

}  // namespace
}  // namespace skybody
