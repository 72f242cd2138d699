// Invalid command lines: one line with the remedy, exit code 2.
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
     "error: no command is given; there are run, check, hash, replay, bench, plugins, modes, plan, "
     "schema, train, tune, plot, new; "
     "see `skybody --help`"},
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
    {"value_twice",
     {"run", "hover", "--seed", "1", "--seed", "2"},
     "error: --seed is given more than once; see `skybody run --help`"},
    {"unknown_policy",
     {"run", "hover", "--policy", "hodl"},
     "error: --policy: there is no policy or file `hodl`; did you mean `hold`?; allowed: zero, "
     "random, hold, shipped, a policy.h5, or a folder with checkpoints; see `skybody run --help`"},
    {"controller_as_policy",
     {"run", "hover", "--policy", "ctbr"},
     "error: --policy: there is no policy or file `ctbr`; `ctbr` is a controller; allowed: zero, "
     "random, hold, shipped, a policy.h5, or a folder with checkpoints; see `skybody run --help`"},
    {"controller_as_scenario",
     {"run", "ctbr"},
     "ctbr: error: neither a file nor a shipped scenario; `ctbr` is a controller; `skybody "
     "plugins` "
     "and `skybody modes` tell more"},
    {"missing_file", {"run", "nowhere.yaml"}, "nowhere.yaml: error: the file does not exist"},
    {"misspelt_scenario",
     {"check", "hovr"},
     "hovr: error: neither a file nor a shipped scenario; did you mean `hover`?"},
    {"no_environments",
     {"hash", "hover", "--envs", "0"},
     "error: --envs: 0 is out of range; allowed: 1..16777216; see `skybody hash --help`"},
    {"large_batch",
     {"hash", "hover", "--envs", "4", "--batch", "8"},
     "error: batch is 8; allowed: 0 ... 4; take at most the number of environments, or 0 for all "
     "of them"},
    {"states_of_no_recording",
     {"hash", "hover", "--states"},
     "error: --states is given without --record FILE, where they would be written"},
    {"no_recording", {"replay"}, "error: FILE is missing; see `skybody replay --help`"},
    {"missing_recording", {"replay", "nowhere.h5"}, "nowhere.h5: error: the file does not exist"},
    {"threads_of_a_comparison",
     {"replay", "a.h5", "--against", "b.h5", "--threads", "2"},
     "error: --against excludes --threads; see `skybody replay --help`"},
    {"unknown_actions",
     {"bench", "hover", "--actions", "hodl"},
     "error: --actions: there is no actions `hodl`; did you mean `hold`?; allowed: hold, zero, "
     "random; see `skybody bench --help`"},
    {"unknown_order",
     {"hash", "hover", "--order", "arival"},
     "error: --order: there is no order `arival`; did you mean `arrival`?; allowed: fixed, "
     "arrival; "
     "see `skybody hash --help`"},
    {"unknown_kind",
     {"new", "contoller", "law"},
     "error: KIND: there is no kind of plugin `contoller`; did you mean `controller`?; allowed: "
     "controller, sensor, randomizer, task, effect; see `skybody new --help`"},
};

INSTANTIATE_TEST_SUITE_P(Lines, WrongCommandLine, testing::ValuesIn(kWrong),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(CommandLine, SaysItsVersion) {
  const Outcome outcome = run_skybody({"--version"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, std::string("skybody ") + version() + "\n");
}

TEST(CommandLine, HelpsWithEveryCommand) {
  for (const char* command :
       {"run", "check", "hash", "replay", "bench", "plugins", "schema", "new"}) {
    const Outcome outcome = run_skybody({command, "--help"});
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_NE(outcome.out.find("Example"), std::string::npos) << command;
    EXPECT_EQ(outcome.err, "") << command;
  }
}

}  // namespace
}  // namespace skybody::test
