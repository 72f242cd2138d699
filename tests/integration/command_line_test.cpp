// Wrong command lines: one line with the remedy, exit code 2.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/version.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

struct Wrong {
  const char* name;
  std::vector<std::string> arguments;
  const char* message;
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

class WrongCommandLine : public testing::TestWithParam<Wrong> {};

TEST_P(WrongCommandLine, GetsOneLineWithTheRemedy) {
  const TemporaryFolder folder;
  const Outcome outcome = run_skybody(GetParam().arguments, {.folder = folder.path()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.err, std::string(GetParam().message) + "\n");
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(folder.names().empty());
}

const Wrong kWrong[] = {
    {"nothing",
     {},
     "error: no command is given; there are run, check, hash, plugins, schema, new; see `skybody "
     "--help`"},
    {"unknown_command",
     {"rnu"},
     "error: unknown command `rnu`; did you mean `run`?; see `skybody --help`"},
    {"no_scenario", {"run"}, "error: SCENARIO is missing; see `skybody run --help`"},
    {"unknown_option",
     {"run", "hover", "--epsiodes", "3"},
     "error: unknown option `--epsiodes`; did you mean `--episodes`?; see `skybody run --help`"},
    {"extra_argument",
     {"check", "hover", "payload"},
     "error: unexpected argument `payload`; see `skybody check --help`"},
    {"not_a_number",
     {"run", "hover", "--episodes", "three"},
     "error: --episodes: `three` is not a whole number; allowed: 1..1000000; see `skybody run "
     "--help`"},
    {"out_of_range",
     {"run", "hover", "--episodes", "0"},
     "error: --episodes: 0 is out of range; allowed: 1..1000000; see `skybody run --help`"},
    {"negative",
     {"run", "hover", "--seed", "-1"},
     "error: --seed: `-1` is not a whole number; allowed: 0..18446744073709551615; see `skybody "
     "run "
     "--help`"},
    {"no_value",
     {"run", "hover", "--seed"},
     "error: --seed is given without its value; see `skybody run --help`"},
    {"unknown_policy",
     {"run", "hover", "--policy", "hodl"},
     "error: --policy: there is no policy `hodl`; did you mean `hold`?; allowed: zero, random, "
     "hold; "
     "see `skybody run --help`"},
    {"missing_file", {"run", "nowhere.yaml"}, "nowhere.yaml: error: the file does not exist"},
    {"many_environments",
     {"hash", "hover", "--envs", "4"},
     "error: --envs is 4; allowed: 1, for the batch engine does not exist yet"},
    {"many_threads",
     {"hash", "hover", "--threads", "2"},
     "error: --threads is 2; allowed: 1, for the batch engine does not exist yet"},
    {"large_batch",
     {"hash", "hover", "--batch", "8"},
     "error: --batch is 8; allowed: 1, for the batch engine does not exist yet"},
    {"unknown_order",
     {"hash", "hover", "--order", "arival"},
     "error: --order: there is no order `arival`; did you mean `arrival`?; allowed: fixed, "
     "arrival; "
     "see `skybody hash --help`"},
    {"unknown_kind",
     {"new", "contoller", "law"},
     "error: KIND: there is no kind of plugin `contoller`; did you mean `controller`?; allowed: "
     "controller, sensor, randomizer, task; see `skybody new --help`"},
};

INSTANTIATE_TEST_SUITE_P(Lines, WrongCommandLine, testing::ValuesIn(kWrong),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(CommandLine, SaysItsVersion) {
  const Outcome outcome = run_skybody({"--version"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, std::string("skybody ") + version() + "\n");
}

TEST(CommandLine, HelpsWithEveryCommand) {
  for (const char* command : {"run", "check", "hash", "plugins", "schema", "new"}) {
    const Outcome outcome = run_skybody({command, "--help"});
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_NE(outcome.out.find("Example"), std::string::npos) << command;
    EXPECT_EQ(outcome.err, "") << command;
  }
}

}  // namespace
}  // namespace skybody::test
