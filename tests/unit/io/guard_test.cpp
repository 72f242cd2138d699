// Untrusted files: small ones with large demands, names and numbers of no real robot, binary data
// in place of text. Bounds are counted, never timed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "core/base/system/printable.h"
#include "core/io/files/file.h"
#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/scenario_reader.h"
#include "tests/unit/io/fake_catalog.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string yaml_error(const std::string& text, Quoting quoting = Quoting::kYes) {
  Diagnostics diagnostics;
  InputBudget budget;
  EXPECT_FALSE(parse_yaml(text, "x.yaml", diagnostics, budget, quoting).has_value());
  return diagnostics.to_string();
}

std::string load_error(const std::string& file) {
  Diagnostics diagnostics;
  EXPECT_FALSE(load_config(file, diagnostics).has_value());
  return diagnostics.to_string();
}

std::string read_error(const std::string& file, const std::vector<std::string>& overrides = {}) {
  Diagnostics diagnostics;
  const FakeCatalog catalog;
  EXPECT_FALSE(read_scenario(file, overrides, catalog, diagnostics).has_value());
  return diagnostics.to_string();
}

std::string repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

TEST(Printable, KeepsTextAndEscapesTheRest) {
  EXPECT_EQ(printable("h\xc3\xa9llo \xe2\x82\xac \xf0\x9f\x9a\x81"),
            "h\xc3\xa9llo \xe2\x82\xac \xf0\x9f\x9a\x81");
  EXPECT_EQ(printable("a\xff\xc3"), "a\\xff\\xc3");
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "a surrogate";
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf") << "overlong";
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond U+10FFFF";
  EXPECT_EQ(printable("\x1b[2J\n\t\x7f"), "\\x1b[2J\\x0a\\x09\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"), "\\xc2\\x9b") << "C1: a terminal takes it for ESC [";
  EXPECT_EQ(printable("\xe2\x80\xae"), "\\xe2\\x80\\xae") << "turns the direction of writing";
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
}

TEST(Printable, ShorteningKeepsCharactersWhole) {
  EXPECT_EQ(shortened("abcdef", 6), "abcdef");
  EXPECT_EQ(shortened("abcdefgh", 4), "ab ... gh");
  const std::string euros = repeated("\xe2\x82\xac", 100);
  const std::string cut = shortened(euros, 40);
  EXPECT_EQ(printable(cut), cut);
}

TEST(Diagnostics, MessagesAreValidTextInOneLine) {
  Diagnostics diagnostics;
  diagnostics.error({"a\xff.yaml", 1, 1}, "no \x1b]0;x\x07 here\nerror: forged");
  EXPECT_EQ(diagnostics.to_string(),
            "a\\xff.yaml:1:1: error: no \\x1b]0;x\\x07 here\\x0aerror: forged\n");
  EXPECT_STREQ(InputError(diagnostics.all()).what(),
               "a\\xff.yaml:1:1: error: no \\x1b]0;x\\x07 here\\x0aerror: forged");
}

TEST(Diagnostics, BeyondAHundredAreCounted) {
  Diagnostics diagnostics;
  for (int i = 0; i < 300'000; ++i) diagnostics.warning({"x", i + 1, 1}, "odd");
  for (int i = 0; i < 101; ++i) diagnostics.error({"x", i + 1, 1}, "bad");
  EXPECT_EQ(diagnostics.all().size(), 202u);
  EXPECT_EQ(diagnostics.error_count(), 101);
  EXPECT_THAT(diagnostics.to_string(),
              AllOf(HasSubstr("warning: 299900 more warnings are not shown"),
                    HasSubstr("error: 1 more error is not shown")));
  Diagnostics both;
  both.add(diagnostics);
  both.add(diagnostics);
  EXPECT_THAT(both.to_string(), HasSubstr("error: 2 more errors are not shown"));
}

TEST(Diagnostics, LongMessagesLoseTheirMiddle) {
  Diagnostics diagnostics;
  diagnostics.error({}, std::string(1 << 20, 'x') + "; remedy");
  EXPECT_LT(diagnostics.to_string().size(), 3000u);
  EXPECT_THAT(diagnostics.to_string(), HasSubstr("; remedy"));
}

TEST(Yaml, AliasesAreCountedWithAllThatTheyRepeat) {
  // 20 times a list of 2 * 10^4 values: one megabyte would expand to 10^8.
  const std::string text =
      "a: &a [" + repeated("1, ", 20'000) + "1]\nb: [" + repeated("*a, ", 20) + "1]\n";
  EXPECT_THAT(yaml_error(text), HasSubstr("x.yaml:2:"));
  EXPECT_THAT(yaml_error(text), HasSubstr("more than 200000 values"));
}

TEST(Yaml, AliasesOfLongTextsAreCountedInBytes) {
  const std::string text =
      "a: &a " + std::string(100'000, 'x') + "\nb: [" + repeated("*a, ", 1000) + "1]\n";
  EXPECT_THAT(yaml_error(text), HasSubstr("32 MiB of text"));
}

TEST(Yaml, AnchorsInEachOtherAreCounted) {
  std::string text;
  for (int i = 0; i < 60; ++i) text += "[&a" + std::to_string(i) + ' ';
  text += '[' + repeated("1, ", 20'000) + "1]" + std::string(60, ']');
  EXPECT_THAT(yaml_error(text), HasSubstr("more than 200000 values"));
}

TEST(Yaml, ManyKeysAreFine) {
  std::string text;
  for (int i = 0; i < 90'000; ++i) text += 'k' + std::to_string(i) + ": 1\n";
  Diagnostics diagnostics;
  const auto root = parse_yaml(text, "x.yaml", diagnostics);
  ASSERT_TRUE(root.has_value()) << diagnostics.to_string();
  ConfigNode merged = *root;
  EXPECT_TRUE(merge_config(merged, *root, diagnostics));
  EXPECT_EQ(merged.entries.size(), 90'000u);
  EXPECT_THAT(yaml_error(text + "k0: 1\n"), HasSubstr("x.yaml:90001:1: error: duplicate key `k0`"));
}

TEST(Yaml, TooManyLevelsNameTheirPlace) {
  const std::string expected = "maps and lists are nested more than 64 levels deep here";
  EXPECT_EQ(yaml_error("a:\n  " + std::string(65, '[') + std::string(65, ']')),
            "x.yaml:2:66: error: " + expected + "; take levels out\n");
  EXPECT_THAT(yaml_error("a:\n  " + std::string(100'000, '[')), HasSubstr(expected));
  EXPECT_THAT(yaml_error(repeated("- ", 100'000) + "1"), HasSubstr(expected));
  EXPECT_THAT(yaml_error(repeated("? ", 100'000) + "1"), HasSubstr(expected));
  EXPECT_THAT(yaml_error(repeated("{a: ", 100'000)), HasSubstr(expected));
}

TEST(Yaml, AliasesAddTheirLevels) {
  std::string text = "a0: &a0 [1]\n";
  for (int i = 1; i < 70; ++i) {
    text += 'a' + std::to_string(i) + ": &a" + std::to_string(i) + " [*a" + std::to_string(i - 1) +
            "]\n";
  }
  EXPECT_THAT(yaml_error(text), HasSubstr("nested more than 64 levels"));
}

TEST(Override, DeepValuesAndLongPathsAreErrors) {
  ConfigNode root;
  Diagnostics diagnostics;
  EXPECT_FALSE(apply_override(root, "a=" + std::string(100'000, '['), diagnostics));
  EXPECT_FALSE(apply_override(root, repeated("a.", 50'000) + "a=1", diagnostics));
  EXPECT_THAT(diagnostics.to_string(), AllOf(HasSubstr("nested more than 64 levels"),
                                             HasSubstr("has 50001 steps; allowed: at most 64")));
  EXPECT_LT(diagnostics.to_string().size(), 2000u);
}

TEST(Override, LongOnesDoNotMultiply) {
  ConfigNode root;
  Diagnostics diagnostics;
  ASSERT_TRUE(apply_override(root, "a=[" + repeated("1, ", 40'000) + "1]", diagnostics));
  EXPECT_LT(cost_of(root).bytes, 300u * 40'001u) << "every value knows where it came from";
}

TEST(Override, MoreThanAThousandAreAnError) {
  TempFolder folder;
  const std::vector<std::string> many(2000, "name=x");
  EXPECT_THAT(read_error(folder.write("x.yaml", "name: x\n"), many),
              HasSubstr("2000 overrides are given; allowed: at most 1000"));
}

TEST(Include, DoublingIsReadOnceEach) {
  TempFolder folder;
  for (int i = 0; i < 40; ++i) {
    const std::string next = std::to_string(i + 1) + ".yaml";
    folder.write(std::to_string(i) + ".yaml",
                 "include: [" + next + ", " + next + "]\nk" + std::to_string(i) + ": 1\n");
  }
  folder.write("40.yaml", "last: 1\n");
  Diagnostics diagnostics;
  const auto root = load_config(folder.path("0.yaml"), diagnostics);
  ASSERT_TRUE(root.has_value()) << diagnostics.to_string();
  EXPECT_EQ(root->entries.size(), 41u);
}

TEST(Include, MoreThanAHundredAreAnError) {
  TempFolder folder;
  folder.write("base.yaml", "a: 1\n");
  EXPECT_THAT(load_error(folder.write(
                  "x.yaml", "include: [" + repeated("base.yaml, ", 100) + "base.yaml]\n")),
              HasSubstr("more than 100 files are included"));
}

TEST(Include, OfABigFileManyTimesIsCounted) {
  TempFolder folder;
  folder.write("base.yaml", "a: [" + repeated("1, ", 50'000) + "1]\n");
  EXPECT_THAT(load_error(folder.write("x.yaml",
                                      "include: [" + repeated("base.yaml, ", 9) + "base.yaml]\n")),
              HasSubstr("more than 200000 values"));
}

TEST(Include, DevicesAndPipesAreRefusedWithoutWaiting) {
  TempFolder folder;
  ASSERT_EQ(mkfifo(folder.path("pipe").c_str(), 0600), 0);
  EXPECT_THAT(load_error(folder.write("a.yaml", "include: pipe\n")),
              HasSubstr("is not a regular file"));
  EXPECT_THAT(load_error(folder.write("b.yaml", "include: /dev/zero\n")),
              HasSubstr("the file `/dev/zero` is not a regular file"));
  EXPECT_THAT(load_error("/dev/zero"), HasSubstr("is not a regular file"));
}

TEST(Include, AFileThatIsNoYamlIsNotQuoted) {
  TempFolder folder;
  folder.write("passwd", "root:x:0:0:secret:/root:/bin/sh\n");
  folder.write("key", "token: secret\ntoken: secret\n*secret\n");
  folder.write("twice", "secret: 1\nsecret: 2\n- [\n");
  for (const char* name : {"passwd", "key", "twice"}) {
    const std::string error = load_error(folder.write("a.yaml", "include: " + std::string(name)));
    EXPECT_THAT(error, AllOf(HasSubstr("error: "), Not(HasSubstr("secret")))) << name;
  }
}

TEST(Include, AFileThatIsNoMapSaysWhatItHolds) {
  TempFolder folder;
  folder.write("passwd", "root:x:0:0:secret:/root:/bin/sh\n");
  EXPECT_EQ(load_error(folder.write("a.yaml", "include: passwd\n")),
            folder.path("passwd") +
                ":1:1: error: the file holds a text; a map of keys and values is needed\n");
}

TEST(Files, ANulInANameIsAnErrorOfItsOwn) {
  TempFolder folder;
  const std::string urdf = folder.write("r.urdf", "<robot name=\"r\"/>");
  EXPECT_FALSE(is_file(urdf + std::string("\0.txt", 5)));
  const std::string robots = "robots: [{name: q, model: \"r.urdf\\0.txt\"}]\n";
  EXPECT_THAT(read_error(folder.write("a.yaml", robots + "task: {plugin: hover}\n")),
              HasSubstr("r.urdf\\x00.txt` cannot exist: its name has a NUL character"));
  EXPECT_THAT(load_error(folder.write("b.yaml", "include: \"a.yaml\\0\"\n")),
              HasSubstr("its name has a NUL character"));
}

TEST(Scenario, TooManyEntriesAreAnError) {
  TempFolder folder;
  const std::string task = "task: {plugin: hover}\n";
  const auto list = [](const std::string& key) {
    return key + ": [" + repeated("{}, ", 1001) + "]\n";
  };
  for (const char* key : {"robots", "obstacles", "sensors"}) {
    EXPECT_THAT(read_error(folder.write("a.yaml", list(key) + task)),
                HasSubstr("` has 1001 entries; allowed: at most 1000"))
        << key;
  }
}

TEST(Rotors, RefuseTimesAndSpeedsThatNoRotorHas) {
  TempFolder folder;
  const std::string rotor =
      "rotors: [{name: a, position: [0, 0, 0], direction: ccw, thrust_constant: 1e-6, "
      "moment_constant: 1e-8, max_speed: 1000, ";
  folder.write("r.urdf",
               "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
               "ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link></robot>");
  const std::string file =
      folder.write("a.yaml", "robots: [{name: q, model: r.urdf}]\ntask: {plugin: hover}\n");
  folder.write("rotors.yaml", rotor + "tau_up: 5e-324}]\n");
  EXPECT_THAT(read_error(file),
              HasSubstr("`tau_up` is 5e-324; allowed: 0, or from 1e-09 to 100 s"));
  folder.write("rotors.yaml", rotor + "axis: [0, 0, 1e-9]}]\n");
  EXPECT_THAT(read_error(file),
              HasSubstr("`axis` is too short; allowed: a length of at least 1e-06"));
}

TEST(Scenario, RobotsTogetherHaveAtMostAThousandBodies) {
  TempFolder folder;
  std::string urdf = "<robot name=\"r\">\n";
  const std::string inertial =
      "<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
      "izz=\"1\"/></inertial>";
  for (int i = 0; i < 400; ++i) {
    urdf += "<link name=\"l" + std::to_string(i) + "\">" + inertial + "</link>\n";
    if (i == 0) continue;
    urdf += "<joint name=\"j" + std::to_string(i) + "\" type=\"continuous\"><parent link=\"l0\"/>" +
            "<child link=\"l" + std::to_string(i) + "\"/></joint>\n";
  }
  folder.write("r.urdf", urdf + "</robot>");
  const std::string file = folder.write(
      "a.yaml",
      "robots:\n  - {name: a, model: r.urdf}\n  - {name: b, model: r.urdf}\n"
      "  - {name: c, model: r.urdf}\n  - {name: d, model: r.urdf}\ntask: {plugin: hover}\n");
  const std::string error = read_error(file);
  EXPECT_THAT(error, HasSubstr("a.yaml:4:22: error: the robots up to this one have 1200 bodies"));
  EXPECT_THAT(error, Not(HasSubstr("a.yaml:5")));
}

TEST(Yaml, RefusesANulCharacterWithItsPlace) {
  Diagnostics diagnostics;
  EXPECT_FALSE(parse_yaml(std::string("a: 1\nb: qdrone\0002\n", 18), "x.yaml", diagnostics));
  EXPECT_EQ(diagnostics.to_string(),
            "x.yaml:2:10: error: not YAML: a NUL character, as in files that are no text; remove "
            "it, or give a text file\n");
}

}  // namespace
}  // namespace skybody
