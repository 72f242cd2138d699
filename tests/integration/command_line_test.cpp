// Invalid command lines: one line with the remedy, exit code 2.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/io/files/shipped_files.h"
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
     "error: no command is given; there are run, check, hash, replay, bench, scenarios, plugins, "
     "modes, plan, "
     "schema, train, tune, render, view, ros1, ros2, sitl, export, import, identify, plot, "
     "onboard, new; "
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
     "random, hold, shipped, a policy.h5, a policy.onnx, or a folder with checkpoints; see "
     "`skybody run --help`"},
    {"controller_as_policy",
     {"run", "hover", "--policy", "ctbr"},
     "error: --policy: there is no policy or file `ctbr`; `ctbr` is a controller; allowed: zero, "
     "random, hold, shipped, a policy.h5, a policy.onnx, or a folder with checkpoints; see "
     "`skybody run --help`"},
    {"controller_as_scenario",
     {"run", "ctbr"},
     "ctbr: error: neither a file nor a shipped scenario; `ctbr` is a controller; `skybody "
     "plugins` "
     "and `skybody modes` tell more"},
    {"missing_file",
     {"run", "nowhere.yaml"},
     "nowhere.yaml: error: the file does not exist; `skybody scenarios` lists the shipped ones"},
    {"another_extension",
     {"run", "hover.yml"},
     "hover.yml: error: the file does not exist; did you mean `hover`?"},
    {"unknown_scenario",
     {"run", "nosuch"},
     "nosuch: error: neither a file nor a shipped scenario; `skybody scenarios` lists the shipped "
     "ones"},
    {"path_of_a_shipped_scenario",
     {"run", "scenarios/hover.yaml"},
     "scenarios/hover.yaml: error: the file does not exist; did you mean `hover`?"},
    {"misspelt_scenario",
     {"check", "hovr"},
     "hovr: error: neither a file nor a shipped scenario; did you mean `hover`?; `skybody "
     "scenarios` lists the shipped ones"},
    {"scenario_for_gates",
     {"plan", "hover", "qdrone2"},
     "error: the file `hover` does not exist; GATES is a YAML file with `start`, `gates` and "
     "`finish`"},
    {"number_with_a_unit",
     {"new", "vehicle", "--mass", "450g", "--arm", "0.2", "--thrust-to-weight", "2"},
     "error: --mass: `450g` is not a number; allowed: 0.001..1000 kg; do you mean 0.45?; see "
     "`skybody new vehicle --help`"},
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
     "error: KIND: there is no kind `contoller`; did you mean `controller`?; allowed: controller, "
     "sensor, randomizer, task, effect, vehicle, lab; see `skybody new --help`"},
    {"misspelt_vehicle",
     {"new", "vehicel", "racer"},
     "error: KIND: there is no kind `vehicel`; did you mean `vehicle`?; allowed: controller, "
     "sensor, randomizer, task, effect, vehicle, lab; see `skybody new --help`"},
    {"lab_of_another_spelling",
     {"new", "lab", "MyLab"},
     "error: `MyLab_law` cannot name a plugin; allowed: at most 64 lower-case letters, digits and "
     "single underscores, a letter first, such as wind_gust"},
    {"mass_out_of_range",
     {"new", "vehicle", "--mass", "1500", "--arm", "0.2", "--thrust-to-weight", "2"},
     "error: --mass: 1500 is out of range; allowed: 0.001..1000 kg; see `skybody new vehicle "
     "--help`"},
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
       {"run", "check", "hash", "replay", "bench", "scenarios", "plugins", "schema", "new"}) {
    const Outcome outcome = run_skybody({command, "--help"});
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_NE(outcome.out.find("Example"), std::string::npos) << command;
    EXPECT_EQ(outcome.err, "") << command;
  }
}

TEST(CommandLine, ListsEveryShippedScenario) {
  const Outcome outcome = run_skybody({"scenarios"});
  EXPECT_EQ(outcome.exit_code, 0);
  for (const std::string& name : shipped_scenarios()) {
    EXPECT_NE(outcome.out.find(name + " "), std::string::npos) << name;
  }
  EXPECT_NE(outcome.out.find("The hover task of the GzDRL paper\n"), std::string::npos);
}

TEST(CommandLine, SaysOfFilesThatAreNoScenariosTheirUse) {
  const TemporaryFolder folder;
  for (const char* name : {"drone.urdf", "flight.h5", "law.so", "program.py"}) {
    std::ofstream(folder.path() / name) << "<robot name=\"drone\">\n</robot>\n";
  }
  std::ofstream(folder.path() / "rotors.yaml") << "rotors: []\n";
  std::filesystem::create_directory(folder.path() / "mine");
  std::ofstream(folder.path() / "mine/rotors.yaml") << "rotors: []\n";
  std::ofstream(folder.path() / "mine/scenario.yaml") << "task: hover\n";
  const auto error = [&](const char* file) {
    const Outcome outcome = run_skybody({"check", file}, {.folder = folder.path()});
    EXPECT_EQ(outcome.exit_code, 2) << file;
    return outcome.err;
  };
  const std::string needed = "; a scenario, which is a YAML file, is needed: ";
  EXPECT_EQ(error("drone.urdf"),
            "drone.urdf: error: a robot's model" + needed +
                "a scenario names it as the `model` of a robot (docs/own_vehicle.md)\n");
  EXPECT_EQ(error("flight.h5"),
            "flight.h5: error: an HDF5 file" + needed +
                "a flight log is for `skybody plot`, a recording for `skybody replay`, a policy "
                "for `skybody run SCENARIO --policy FILE`\n");
  EXPECT_EQ(error("law.so"), "law.so: error: a plugin's library" + needed +
                                 "a scenario names its plugins (docs/plugins.md)\n");
  EXPECT_EQ(error("program.py"),
            "program.py: error: a Python program" + needed + "start it with Python\n");
  EXPECT_EQ(
      error("mine"),
      "mine: error: a folder; give the YAML file of a scenario, such as mine/scenario.yaml\n");
  EXPECT_EQ(error("rotors.yaml"), "rotors.yaml: error: a rotors file" + needed +
                                      "a scenario names the URDF beside it (docs/rotors.md)\n");
}

TEST(CommandLine, DoubtsAVehicleWhoseSizeDoesNotFitItsMass) {
  const TemporaryFolder folder;
  const auto warning = [&](const char* name, const char* mass, const char* arm) {
    const Outcome outcome = run_skybody(
        {"new", "vehicle", name, "--mass", mass, "--arm", arm, "--thrust-to-weight", "3"},
        {.folder = folder.path()});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.err;
  };
  EXPECT_EQ(warning("grams", "45", "0.11"),
            "warning: `--arm` (0.11 m) by the cube root of `--mass` (45 kg) is 0.03093 m/kg^(1/3); "
            "usual is 0.05 to 0.6 m/kg^(1/3); do you mean `--mass 0.045` (g written for kg)?\n");
  EXPECT_EQ(warning("centimetres", "0.03", "2"),
            "warning: `--arm` (2 m) by the cube root of `--mass` (0.03 kg) is 6.437 m/kg^(1/3); "
            "usual is 0.05 to 0.6 m/kg^(1/3); do you mean `--arm 0.02` (cm written for m)?\n");
  EXPECT_EQ(warning("usual", "1.5", "0.2"), "");
}

}  // namespace
}  // namespace skybody::test
