// The commands check, hash, plugins, schema and new, run through the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/files/shipped_files.h"
#include "core/io/yaml/config_tree.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::StartsWith;

const char* const kHover = "hover";
const char* const kRotors = SKYBODY_SOURCE_DIR "/scenarios/models/racer/rotors.yaml";

TEST(Check, SaysOkAboutEveryShippedScenario) {
  for (const std::string& name : shipped_scenarios()) {
    const Outcome outcome = run_skybody({"check", find_shipped_scenario(name)->string()});
    EXPECT_EQ(outcome.exit_code, 0) << name;
    EXPECT_THAT(outcome.out, StartsWith("ok: "));
    EXPECT_EQ(outcome.err, "");
  }
}

TEST(Check, FindsAShippedScenarioByItsName) {
  const TemporaryFolder folder;
  const Outcome outcome = run_skybody({"check", "hover"}, {.folder = folder.path()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST(Check, FindsAShippedScenarioBesideAFolderOfItsName) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(std::filesystem::path(folder.path()) / "hover");
  const Outcome outcome = run_skybody({"check", "hover"}, {.folder = folder.path()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST(Check, ListsRandomizableParameters) {
  const Outcome outcome = run_skybody({"check", kHover, "--parameters"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("nominal"), HasSubstr(".mass"),
                                 HasSubstr("rotors[0].thrust_constant")));
}

TEST(Check, WarningsAloneAreNoError) {
  const std::filesystem::path urdf = SKYBODY_SOURCE_DIR "/../shared/data/urdf/racer.urdf";
  if (!std::filesystem::exists(urdf)) GTEST_SKIP() << "shared/data/urdf is not here";
  const Outcome outcome =
      run_skybody({"check", kHover, "--set", "robots.quad.model=" + urdf.string(), "--set",
                   std::string("robots.quad.rotors=") + kRotors});
  EXPECT_THAT(outcome.err, ContainsRegex("racer.urdf:5:[0-9]+: warning: "));
  EXPECT_EQ(outcome.err.find("error"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.exit_code, 0);
}

TEST(Check, WarnsOfARobotThatBeginsInsideAnObstacleHoweverLarge) {
  for (const char* size : {"[0.3, 0.3, 0.3]", "[10, 10, 10]"}) {
    const std::string box = "{name: wall, position: [0, 0, 1], box: " + std::string(size) + "}";
    const Outcome outcome = run_skybody(
        {"check", kHover, "--set", "randomization=[]", "--set", "obstacles=[" + box + "]"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_THAT(
        outcome.err,
        HasSubstr("hover.yaml:5:5: warning: robot `quad` begins inside the obstacle `wall`, by "));
  }
}

TEST(Check, WarnsWhereSomeOfTheStartsThatAreDrawnFailAtOnce) {
  const std::string place = "randomization.start.parameters.position_max=[9, 5, 3]";
  const Outcome outcome = run_skybody({"check", kHover, "--set", place});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("warning: 3 of 32 drawn episodes begin as a failure: "
                                     "`failed.bound` (a coordinate beyond `bound`), such as with "
                                     "robot `quad` at ["));
}

TEST(Check, WarnsOfRobotsThatBeginInsideEachOther) {
  const Outcome outcome =
      run_skybody({"check", "collision", "--set", "robots.left.pose.position=[0, 0, 2]", "--set",
                   "robots.right.pose.position=[0, 0, 2]"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("robot `left` begins inside robot `right`, by "));
}

TEST(Check, WarnsWhereTheStepIsLargerThanTheAuditSupports) {
  const Outcome coarse = run_skybody(
      {"check", kHover, "--set", "stepping={dt: 0.01, integrator: semi_implicit_euler}"});
  EXPECT_EQ(coarse.exit_code, 0);
  EXPECT_EQ(coarse.err,
            "--set stepping={dt: 0.01, integrator: semi_implicit_euler}: warning: `dt` is 0.01 s; "
            "the audit in docs/results/integrators.md "
            "supports up to 0.001 s with `semi_implicit_euler` (errors below 8 mm and 0.5 degrees "
            "after a second of flight): take a smaller one, or the default integrator with at most "
            "0.004 s\n");
  const Outcome fine = run_skybody({"check", kHover, "--set", "stepping.dt=0.004"});
  EXPECT_EQ(fine.exit_code, 0);
  EXPECT_EQ(fine.err, "");
}

/// A link with its centre of mass at height z.
std::string urdf_link(const std::string& name, const std::string& z, const std::string& kg,
                      const std::string& inertia) {
  return "<link name='" + name + "'><inertial><origin xyz='0 0 " + z + "'/><mass value='" + kg +
         "'/><inertia ixx='" + inertia + "' iyy='" + inertia + "' izz='" + inertia +
         "' ixy='0' ixz='0' iyz='0'/></inertial></link>";
}

/// A base of 1 kg with a chain of eight rods of 0.1 m and the given mass, and 0.5 kg at the end.
std::string chain_urdf(const std::string& mass, const std::string& inertia_of_rod) {
  std::string text = "<robot name='chain'>" + urdf_link("base", "0", "1", "0.01");
  std::string parent = "base";
  for (int i = 0; i < 8; ++i) {
    const std::string name = "link" + std::to_string(i);
    text += urdf_link(name, "-0.05", mass, inertia_of_rod) + "<joint name='" + name + "_joint' " +
            "type='continuous'><origin xyz='0 0 " + (i == 0 ? "0" : "-0.1") + "'/><parent link='" +
            parent + "'/><child link='" + name + "'/><axis xyz='0 1 0'/></joint>";
    parent = name;
  }
  return text + urdf_link("load", "0", "0.5", "2e-4") +
         "<joint name='weld' type='fixed'><origin xyz='0 0 -0.1'/><parent link='link7'/>"
         "<child link='load'/></joint></robot>";
}

TEST(Check, WarnsOfLinksThatAreTooLightForTheStep) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "chain.yaml")
      << "stepping: {dt: 0.001}\nrobots:\n  - name: chain\n    model: chain.urdf\n"
         "    pose: {position: [0, 0, 2]}\n    controllers: [{plugin: wrench, parameters: "
         "{max_force: [20, 20, 20], max_moment: [1, 1, 1]}}]\ntask: {plugin: hover}\n";
  const auto check = [&](const std::string& mass, const std::string& inertia) {
    std::ofstream(folder.path() / "chain.urdf") << chain_urdf(mass, inertia);
    return run_skybody({"check", (folder.path() / "chain.yaml").string()});
  };
  const Outcome light = check("0.0001", "8.3e-8");
  EXPECT_EQ(light.exit_code, 0);
  EXPECT_THAT(
      light.err,
      ContainsRegex("chain.urdf:1:226: warning: link `link0` of robot `chain` has 0.0001 kg "
                    "and carries 0.5007 kg: where these swing it whips, and steps of 0.001 "
                    "s gain energy or end in a fault; give such links 0.01[0-9]+ kg, or "
                    "take a `dt` of 1.[0-9]+e-05 s, which held in all that was measured"));
  EXPECT_EQ(check("0.02", "1.66e-5").err, "");
}

/// A finger of 5 g on a hinge with a damper, a spring, or neither.
std::string finger_urdf(const std::string& dynamics) {
  return "<robot name='finger'>" + urdf_link("base_link", "0", "1", "0.01") +
         urdf_link("finger", "0", "0.005", "1.5e-6") +
         "<joint name='hinge' type='continuous'><parent link='base_link'/><child link='finger'/>"
         "<axis xyz='1 0 0'/><dynamics " +
         dynamics + "/></joint></robot>";
}

// Expected rates by hand: for the damper d (1 / 1.5e-6 + 1 / 0.01), for the spring the square root
// of the same expression with k in place of d.
TEST(Check, WarnsOfJointsThatAreTooStiffForTheStep) {
  const TemporaryFolder folder;
  const auto check = [&](const std::string& dynamics, const std::string& stepping) {
    std::ofstream(folder.path() / "finger.urdf") << finger_urdf(dynamics);
    std::ofstream(folder.path() / "finger.yaml")
        << "stepping: " << stepping
        << "\nrobots:\n  - name: hand\n    model: finger.urdf\n    rotors: none\n"
           "    pose: {position: [0, 0, 2]}\n    controllers: []\n"
           "task: {plugin: watch, parameters: {link: base_link}}\n";
    return run_skybody({"check", (folder.path() / "finger.yaml").string()}).err;
  };
  EXPECT_THAT(
      check("damping='0.01'", "{dt: 0.001}"),
      HasSubstr("finger.urdf:1:446: warning: joint `hinge` of robot `hand` has a damping that "
                "moves its light links within 0.00015 s: steps of 0.001 s do not follow, "
                "and from 0.0003 s on they end in a fault; take a `dt` of at most 0.00015 "
                "s, a smaller damping, heavier links, or `integrator: cvode`"));
  EXPECT_EQ(check("damping='0.01'", "{dt: 0.0001}"), "");
  EXPECT_EQ(check("damping='0.01'", "{dt: 0.001, integrator: cvode}"), "");
  EXPECT_EQ(check("damping='0.001'", "{dt: 0.001}"), "");
}

TEST(Hash, IsTheSameLineInTwoProcesses) {
  const std::vector<std::string> arguments = {"hash",      kHover, "--envs",  "1",
                                              "--threads", "1",    "--batch", "1",
                                              "--steps",   "500",  "--seed",  "7"};
  const Outcome first = run_skybody(arguments), second = run_skybody(arguments);
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, MatchesRegex("[0-9a-f]{16}\n"));
  EXPECT_EQ(first.out, second.out);
}

TEST(Hash, DependsOnSeedStepsAndScenario) {
  const std::string base = run_skybody({"hash", kHover, "--steps", "50", "--seed", "7"}).out;
  EXPECT_NE(base, run_skybody({"hash", kHover, "--steps", "50", "--seed", "8"}).out);
  EXPECT_NE(base, run_skybody({"hash", kHover, "--steps", "51", "--seed", "7"}).out);
  EXPECT_NE(base, run_skybody({"hash", kHover, "--steps", "50", "--seed", "7", "--set",
                               "gravity=[0, 0, -9.8]"})
                      .out);
}

TEST(Hash, DoesNotDependOnTheOrderOfOneEnvironment) {
  EXPECT_EQ(run_skybody({"hash", kHover, "--steps", "50", "--order", "fixed"}).out,
            run_skybody({"hash", kHover, "--steps", "50", "--order", "arrival"}).out);
}

TEST(Hash, GoesOnThroughEndedEpisodes) {
  const Outcome outcome =
      run_skybody({"hash", kHover, "--steps", "50", "--set", "stepping.horizon=7"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, MatchesRegex("[0-9a-f]{16}\n"));
}

TEST(Plugins, ListsWhatIsShipped) {
  const Outcome outcome = run_skybody({"plugins"});
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* line :
       {"ctbr +controller", "imu +sensor", "vehicle_constants +randomizer", "hover +task"}) {
    EXPECT_THAT(outcome.out, ContainsRegex(line));
  }
  EXPECT_THAT(run_skybody({"plugins", "--verbose"}).out, HasSubstr("parameter"));
}

TEST(Plugins, ListsWhatCannotBeUsedWithTheReason) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "broken.so") << "not a library";
  const Outcome outcome = run_skybody({"plugins", "--plugin-path", folder.path().string()});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("cannot be used:"), HasSubstr("broken.so: ")));
}

TEST(Plugins, PrintsAParameterTableInMarkdown) {
  const Outcome outcome = run_skybody({"plugins", "--markdown", "sensor/imu"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, StartsWith("| Parameter | Type | Unit |"));
  const Outcome wrong = run_skybody({"plugins", "--markdown", "sensor/imv"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_EQ(wrong.err,
            "error: --markdown: there is no plugin `sensor/imv`; did you mean `sensor/imu`?\n");
}

TEST(Schema, MarkdownIsWhatTheDocumentationShows) {
  std::ifstream file(SKYBODY_SOURCE_DIR "/docs/scenarios.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  const Outcome outcome = run_skybody({"schema", "--markdown"});
  EXPECT_NE(page.find(outcome.out), std::string::npos)
      << "docs/scenarios.md is behind: scripts/update_docs.sh writes it anew";
}

TEST(Schema, IsJsonThatNamesThePlugins) {
  const Outcome outcome = run_skybody({"schema"});
  EXPECT_EQ(outcome.exit_code, 0);
  Diagnostics diagnostics;
  const auto schema = parse_yaml(outcome.out, "schema", diagnostics);  // JSON is YAML
  ASSERT_TRUE(schema.has_value()) << diagnostics.to_string();
  EXPECT_NE(schema->find("$schema"), nullptr);
  EXPECT_NE(schema->find("properties"), nullptr);
  EXPECT_THAT(outcome.out, HasSubstr("\"ctbr\""));
}

TEST(New, WritesAProjectOnce) {
  const TemporaryFolder folder;
  const std::vector<std::string> arguments = {"new", "controller", "my_law", "--dir",
                                              folder.path().string()};
  const Outcome outcome = run_skybody(arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "my_law" / "README.md"));
  EXPECT_EQ(run_skybody(arguments).exit_code, 2);
}

}  // namespace
}  // namespace skybody::test
