// Runs every bad input of tests/bad_input/cases.yaml through the real program. Checks the exact
// messages, the exit code, that nothing crashes, and that no file appears in the working directory.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/yaml/config_tree.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;

struct Case {
  std::string name;
  std::vector<std::string> arguments;
  std::vector<std::string> stderr_lines;
  int exit_code = 2;
  std::vector<std::string> needs;  ///< test plugins that the case needs, see add_plugins()
  std::string built;               ///< a shipped plugin that the build may lack
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
    cases.push_back(
        {node.find("name")->scalar, scalars(*node.find("arguments")), scalars(*node.find("stderr")),
         std::stoi(node.find("exit")->scalar),
         node.find("needs") == nullptr ? std::vector<std::string>{} : scalars(*node.find("needs")),
         node.find("built") == nullptr ? "" : node.find("built")->scalar});
  }
  return cases;
}

/// Links `tests` and `scenarios` into a folder, so that paths below them resolve as in the
/// project's root.
void imitate_root(const fs::path& folder) {
  for (const char* name : {"tests", "scenarios"}) {
    fs::create_directory_symlink(fs::path(SKYBODY_SOURCE_DIR) / name, folder / name);
  }
}

/// Copies plugins of the build's tests/plugins into the folder `plugins`. Forms of an entry:
/// - `bad/wrong_version.so`: the file as it is
/// - `truncated good/plain_controller.so`: the file's first half, as truncated.so
/// - `zeroed ...`: the file with its last 4 KiB set to zero, as zeroed.so
void add_plugins(const fs::path& folder, const std::vector<std::string>& needs) {
  fs::create_directory(folder / "plugins");
  for (const std::string& need : needs) {
    const std::size_t space = need.find(' ');
    const std::string damage = space == std::string::npos ? "" : need.substr(0, space);
    const fs::path source =
        fs::path(SKYBODY_BINARY_DIR "/tests/plugins") / need.substr(damage.empty() ? 0 : space + 1);
    const fs::path place =
        folder / "plugins" / (damage.empty() ? source.filename() : fs::path(damage + ".so"));
    fs::copy_file(source, place);
    if (damage == "truncated") fs::resize_file(place, 9000);
    if (damage == "zeroed") {
      const std::uintmax_t size = fs::file_size(place);
      fs::resize_file(place, size - 4096);
      fs::resize_file(place, size);
    }
  }
}

/// Replaces the text between `before` and the next `after` by N.
void replace_word(std::string& line, const std::string& before, const std::string& after) {
  const std::size_t at = line.find(before);
  if (at == std::string::npos) return;
  const std::size_t begin = at + before.size();
  line.replace(begin, line.find(after, begin) - begin, "N");
}

/// Messages without the test's folder and without the sizes of libraries, which differ between
/// builds.
std::vector<std::string> portable(std::vector<std::string> lines, const fs::path& folder) {
  const std::string place = fs::canonical(folder).string() + "/";
  for (std::string& line : lines) {
    for (std::size_t at; (at = line.find(place)) != std::string::npos;)
      line.erase(at, place.size());
    replace_word(line, "bytes of at least ", ";");
    replace_word(line, "probe gives ", " ");
  }
  return lines;
}

class BadInput : public testing::TestWithParam<Case> {};

TEST_P(BadInput, GetsItsMessageAndLeavesNothingBehind) {
  const std::string& built = GetParam().built;
  if (!built.empty() && !fs::exists(SKYBODY_BINARY_DIR "/lib/skybody/plugins/" + built + ".so")) {
    GTEST_SKIP() << "built without " << built;
  }
  const TemporaryFolder folder;
  imitate_root(folder.path());
  ProcessOptions options{.folder = folder.path()};
  if (!GetParam().needs.empty()) {
    add_plugins(folder.path(), GetParam().needs);
    options.environment = {"SKYBODY_PLUGIN_PATH=plugins"};
  }
  const std::vector<std::string> before = folder.names();
  const Outcome outcome = run_skybody(GetParam().arguments, options);
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.exit_code, GetParam().exit_code);
  EXPECT_EQ(portable(lines_of(outcome.err), folder.path()), GetParam().stderr_lines);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(folder.names(), before);
}

INSTANTIATE_TEST_SUITE_P(Cases, BadInput, testing::ValuesIn(read_cases()),
                         [](const auto& test) { return test.param.name; });

TEST(BadInputCases, AreAtLeastThirtyFiles) { EXPECT_GE(read_cases().size(), 30u); }

}  // namespace
}  // namespace skybody::test
