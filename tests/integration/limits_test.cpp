// Small files with large demands, run through the real program with little memory. Each must give
// one clear error or fly, without a crash. The kernel limits memory; only ctest limits time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/integration/process.h"

namespace skybody::test {
namespace {

using ::testing::HasSubstr;

constexpr int kMegabyte = 1'000'000;
// docs/scenarios.md promises at most 500 MB for the heap. A sanitizer needs additional memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr const char* kMemory = "--data=unlimited";
#else
constexpr const char* kMemory = "--data=500000000";
#endif
// The promise is 2 s on the project's machine; sanitizers and slow machines take longer.
constexpr const char* kProcessorTime = "--cpu=20";

const std::string kRobot =
    "robots: [{name: q, model: qdrone2, pose: {position: [0, 0, 1]}, controllers: [{plugin: "
    "rotor_speed}]}]\ntask: {plugin: hover}\n";
const std::string kInertial =
    "<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
    "izz=\"1\"/></inertial>";

/// A megabyte of copies of `piece`; # is replaced by the number of the copy.
std::string megabyte_of(const std::string& piece) {
  std::string text;
  for (int i = 0; text.size() < kMegabyte; ++i) {
    for (const char c : piece) {
      if (c == '#') {
        text += std::to_string(i);
      } else {
        text += c;
      }
    }
  }
  return text;
}

class Limits : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name) << text;
  }

  /// Messages of `check` on a file with this text.
  std::string check(const std::string& text, const std::vector<std::string>& more = {}) const {
    write("x.yaml", text);
    std::vector<std::string> arguments = {kMemory, kProcessorTime, SKYBODY_PROGRAM, "check",
                                          "x.yaml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run_program("prlimit", arguments, {.folder = folder_.path()});
    EXPECT_EQ(outcome.signal, 0);
    EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 2) << outcome.exit_code;
    EXPECT_LT(outcome.err.size(), 100'000u) << "errors are counted, not all shown";
    return outcome.err;
  }

  std::string check_urdf(const std::string& text) const {
    write("r.urdf", text);
    return check("robots: [{name: q, model: r.urdf}]\ntask: {plugin: hover}\n");
  }

  const TemporaryFolder folder_;
};

TEST_F(Limits, AliasesThatExpand) {
  EXPECT_THAT(check(kRobot + "a: &a [" + megabyte_of("1, ").substr(0, 150'000) + "1]\nb: [" +
                    megabyte_of("*a, ") + "1]\n"),
              HasSubstr("more than 200000 values"));
  EXPECT_THAT(check(kRobot + "a: &a " + std::string(500'000, 'x') + "\nb: [" + megabyte_of("*a, ") +
                    "1]\n"),
              HasSubstr("32 MiB of text"));
}

TEST_F(Limits, IncludesThatDouble) {
  for (int i = 0; i < 30; ++i) {
    const std::string next = std::to_string(i + 1) + ".yaml";
    write(std::to_string(i) + ".yaml", "include: [" + next + ", " + next + "]\n");
  }
  write("30.yaml", "name: x\n");
  EXPECT_EQ(check("include: 0.yaml\n" + kRobot), "");
}

TEST_F(Limits, ManyKeysValuesAndLevels) {
  EXPECT_THAT(check(kRobot + megabyte_of("k#: 1\n")), HasSubstr("more than 200000 values"));
  EXPECT_THAT(check(kRobot + megabyte_of("a_long_key_#: 1\n")),
              HasSubstr("more errors are not shown"));
  EXPECT_THAT(check(kRobot + megabyte_of("name: x\n")), HasSubstr("more errors are not shown"));
  EXPECT_THAT(check(kRobot + "x: [" + megabyte_of("1,") + "1]\n"), HasSubstr("values"));
  EXPECT_THAT(check(kRobot + "x: " + megabyte_of("[")), HasSubstr("more than 64 levels"));
  EXPECT_THAT(check(kRobot + "x: " + megabyte_of("{a: ")), HasSubstr("more than 64 levels"));
  EXPECT_THAT(check(kRobot + "x: " + megabyte_of("a")), HasSubstr("unknown key `x`"));
  EXPECT_THAT(check(kRobot + "gravity: \"" + megabyte_of("a\\n") + "\"\n"),
              HasSubstr("allowed: a list of 3 numbers"));
}

TEST_F(Limits, ManyRobotsObstaclesAndSensors) {
  const std::string most = "entries; allowed: at most 1000";
  EXPECT_THAT(check("robots:\n" + megabyte_of("- {name: q#, model: qdrone2}\n") +
                    "task: {plugin: hover}\n"),
              HasSubstr(most));
  EXPECT_THAT(check(kRobot + "obstacles:\n" + megabyte_of("- {name: q#, sphere: 1}\n")),
              HasSubstr(most));
  EXPECT_THAT(check(kRobot + "sensors:\n" + megabyte_of("- {name: q#, plugin: imu}\n")),
              HasSubstr(most));
}

TEST_F(Limits, OverridesThatAreDeepOrMany) {
  EXPECT_THAT(check(kRobot, {"--set", "gravity=" + std::string(100'000, '[')}),
              HasSubstr("more than 64 levels"));
  EXPECT_THAT(check(kRobot, {"--set", "a=[" + megabyte_of("1,").substr(0, 100'000) + "1]"}),
              HasSubstr("unknown key `a`"));
  std::vector<std::string> many;
  for (int i = 0; i < 1001; ++i) many.insert(many.end(), {"--set", "name=x"});
  EXPECT_THAT(check(kRobot, many), HasSubstr("1001 overrides are given; allowed: at most 1000"));
}

TEST_F(Limits, UrdfsWithManyLinksJointsAndShapes) {
  const std::string head = "<robot name=\"r\">", tail = "</robot>";
  EXPECT_THAT(check_urdf(head + megabyte_of("<link name=\"l#\"/>") + tail),
              HasSubstr("more than 10000 links"));
  EXPECT_THAT(check_urdf(head + megabyte_of("<link name=\"l\"/>\n") + tail),
              HasSubstr("more errors are not shown"));
  EXPECT_THAT(check_urdf(head + "<link name=\"a\"/>" +
                         megabyte_of("<joint name=\"j#\" type=\"fixed\"><parent link=\"x#\"/>"
                                     "<child link=\"y#\"/></joint>") +
                         tail),
              HasSubstr("more than 10000 joints"));
  EXPECT_THAT(
      check_urdf(head + "<link name=\"a\">" + kInertial +
                 megabyte_of("<visual><geometry><sphere radius=\"1\"/></geometry></visual>") +
                 "</link>" + tail),
      HasSubstr("more than 10000 shapes"));
  EXPECT_THAT(check_urdf(head + megabyte_of("<a>")), HasSubstr("element depth exceeded"));
  EXPECT_THAT(check_urdf(head + "<link" + megabyte_of(" a#=\"\"") + "/>" + tail),
              HasSubstr("more than 100 attributes"));
}

TEST_F(Limits, UrdfsWithLongChains) {
  for (const char* type : {"fixed", "continuous"}) {
    std::string text = "<robot name=\"r\"><link name=\"l0\">" + kInertial + "</link>";
    for (int i = 1; i < 4500; ++i) {
      const std::string name = std::to_string(i), before = std::to_string(i - 1);
      text += "<link name=\"l" + name + "\">" + kInertial + "</link><joint name=\"j" + name +
              "\" type=\"" + type + "\"><parent link=\"l" + before + "\"/><child link=\"l" + name +
              "\"/></joint>";
    }
    const std::string error = check_urdf(text + "</robot>");
    const bool fixed = std::string(type) == "fixed";
    EXPECT_THAT(error, HasSubstr(fixed ? "takes no action" : "have 4500 bodies")) << type;
  }
}

}  // namespace
}  // namespace skybody::test
