#include "core/io/yaml/config_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

using ::testing::HasSubstr;

ConfigNode parse(const std::string& text) {
  Diagnostics diagnostics;
  const auto node = parse_yaml(text, "x.yaml", diagnostics);
  EXPECT_TRUE(node.has_value()) << diagnostics.to_string();
  return node.value_or(ConfigNode{});
}

std::string parse_error(const std::string& text) {
  Diagnostics diagnostics;
  EXPECT_FALSE(parse_yaml(text, "x.yaml", diagnostics).has_value());
  return diagnostics.to_string();
}

TEST(Yaml, KeysAndValuesKnowTheirPlaces) {
  const ConfigNode root = parse("a: 1\nb:\n  c: [2, three]\n");
  EXPECT_EQ(root.keys(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(root.entries[1].key_mark.line, 2);
  EXPECT_EQ(root.entries[1].key_mark.column, 1);
  const ConfigNode& list = *root.find("b")->find("c");
  ASSERT_EQ(list.items.size(), 2u);
  EXPECT_EQ(list.items[1].scalar, "three");
  EXPECT_EQ(to_string(list.items[1].mark), "x.yaml:3:10");
}

TEST(Yaml, AliasesAreExpanded) {
  const ConfigNode root = parse("a: &one {x: [1, 2]}\nb: *one\n");
  EXPECT_EQ(root.find("b")->find("x")->items[1].scalar, "2");
}

TEST(Yaml, DuplicateKeyNamesBothPlaces) {
  EXPECT_EQ(parse_error("a: 1\nb: 2\na: 3\n"),
            "x.yaml:3:1: error: duplicate key `a`; it stands at x.yaml:1:1 already; remove one\n");
}

TEST(Yaml, EveryDuplicateIsReported) {
  Diagnostics diagnostics;
  parse_yaml("a: {b: 1, b: 2}\nc: 1\nc: 2\n", "x.yaml", diagnostics);
  EXPECT_EQ(diagnostics.error_count(), 2);
}

TEST(Yaml, SyntaxErrorsHaveAPlace) {
  EXPECT_THAT(parse_error("a: [1, 2\nb: 3\n"), HasSubstr("x.yaml:2:2: error: not YAML"));
}

TEST(Yaml, TagsAreRefused) {
  EXPECT_EQ(parse_error("a: !!float 1\n"),
            "x.yaml:1:4: error: the tag `!!float`; tags are not allowed: write the value alone\n");
  EXPECT_THAT(parse_error("a: !mine {b: 1}\n"), HasSubstr("the tag `!mine`"));
  EXPECT_THAT(parse_error("a: !!seq [1]\n"), HasSubstr("the tag `!!seq`"));
  EXPECT_TRUE(parse("a: '1'\nb: [x]\nc: {d: \"e\"}\n").is_map());
}

TEST(Yaml, SecondDocumentIsAnError) {
  EXPECT_THAT(parse_error("a: 1\n---\nb: 2\n"), HasSubstr("a second document"));
}

TEST(Yaml, AliasInsideItselfIsAnError) {
  EXPECT_THAT(parse_error("a: &a [*a]\n"), HasSubstr("contains it"));
}

TEST(Yaml, AliasesThatExplodeAreAnError) {
  std::string text = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 20; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before;
    for (int k = 0; k < 9; ++k) text += ", " + before;
    text += "]\n";
  }
  EXPECT_THAT(parse_error(text), HasSubstr("more than 200000 values"));
}

TEST(Yaml, DeepNestingIsAnErrorAndNoCrash) {
  EXPECT_THAT(parse_error(std::string(100000, '[')), HasSubstr("error"));
}

TEST(Yaml, WrittenTreeReadsBackTheSame) {
  const std::string text =
      "name: \"a: b\"\nquoted: \"12\"\nnumbers: [1, -2.5, 1e-3]\nnothing: ~\nempty: {}\n"
      "list:\n  - {name: x, sub: {deep: [[1, 2], [3]]}}\n  - plain\n  - [a, b]\n"
      "odd: \"line\\nbreak \\\"quote\\\" \\\\ # no comment\"\n";
  const std::string once = to_yaml(parse(text));
  EXPECT_EQ(to_yaml(parse(once)), once);
  const ConfigNode back = parse(once);
  EXPECT_EQ(back.find("name")->scalar, "a: b");
  EXPECT_TRUE(back.find("quoted")->quoted);
  EXPECT_EQ(back.find("odd")->scalar, "line\nbreak \"quote\" \\ # no comment");
  EXPECT_TRUE(back.find("nothing")->is_null());
  EXPECT_TRUE(back.find("empty")->is_map());
  EXPECT_EQ(back.find("list")->items[0].find("sub")->find("deep")->items[1].items[0].scalar, "3");
}

TEST(Include, IncludingFileOverridesAndMapsMergeDeeply) {
  TempFolder folder;
  folder.write("base.yaml", "a: {x: 1, y: 2}\nlist: [1, 2]\n");
  folder.write("more.yaml", "a: {y: 3}\n");
  const std::string file =
      folder.write("top.yaml", "include: [base.yaml, more.yaml]\na: {z: 4}\nlist: [9]\n");
  Diagnostics diagnostics;
  const auto root = load_config(file, diagnostics);
  ASSERT_TRUE(root.has_value()) << diagnostics.to_string();
  EXPECT_EQ(to_yaml(*root), "a:\n  x: 1\n  y: 3\n  z: 4\nlist: [9]\n");
  EXPECT_EQ(root->find("a")->find("y")->mark.file, folder.path("more.yaml"));
}

TEST(Include, AKeyWithoutAValueRemovesWhatIncludedFilesGive) {
  const TempFolder folder;
  folder.write("base.yaml", "a: {x: 1, y: {z: 2}}\nb: 3\n");
  folder.write("top.yaml", "include: base.yaml\na: {y: ~, w: 4}\nb: null\nc: ~\n");
  Diagnostics diagnostics;
  const auto root = load_config(folder.path("top.yaml"), diagnostics);
  ASSERT_TRUE(root.has_value()) << diagnostics.to_string();
  EXPECT_EQ(to_yaml(*root), "a:\n  x: 1\n  w: 4\nc: null\n") << "what nobody gives stays";
}

TEST(Include, ANameWithoutAValueRemovesAnEntryOfAList) {
  const TempFolder folder;
  folder.write("base.yaml", "robots: [{name: a}, {name: b}, {name: c}]\n");
  folder.write("top.yaml", "include: base.yaml\nrobots: {b: ~, c: {mass: 2}}\n");
  Diagnostics diagnostics;
  const auto root = load_config(folder.path("top.yaml"), diagnostics);
  ASSERT_TRUE(root.has_value()) << diagnostics.to_string();
  EXPECT_EQ(to_yaml(*root), "robots:\n  - name: a\n  - name: c\n    mass: 2\n");
}

TEST(Include, AMapInThePlaceOfAListPatchesTheEntriesThatItNames) {
  const TempFolder folder;
  folder.write("base.yaml",
               "robots:\n  - {name: a, pose: {position: [1, 2, 3], yaw: 1}}\n  - {name: b}\n"
               "effects: [{plugin: wind, parameters: {speed: 1}}]\n");
  folder.write("top.yaml",
               "include: base.yaml\nrobots:\n  a: {pose: {yaw: 2}}\n"
               "effects: {wind: {parameters: {speed: 3}}}\n");
  Diagnostics diagnostics;
  const auto root = load_config(folder.path("top.yaml"), diagnostics);
  ASSERT_TRUE(root.has_value()) << diagnostics.to_string();
  const ConfigNode& robots = *root->find("robots");
  ASSERT_EQ(robots.items.size(), 2u);
  EXPECT_EQ(robots.items[0].find("pose")->find("yaw")->scalar, "2");
  EXPECT_EQ(robots.items[0].find("pose")->find("position")->items[2].scalar, "3");
  EXPECT_EQ(root->find("effects")->items[0].find("parameters")->find("speed")->scalar, "3");
}

TEST(Include, APatchOfAnEntryThatTheListLacksNamesThoseThatItHas) {
  const TempFolder folder;
  folder.write("base.yaml", "robots: [{name: quad}]\n");
  folder.write("top.yaml", "include: base.yaml\nrobots:\n  qaud: {pose: {yaw: 2}}\n");
  Diagnostics diagnostics;
  EXPECT_FALSE(load_config(folder.path("top.yaml"), diagnostics).has_value());
  EXPECT_THAT(
      diagnostics.to_string(),
      HasSubstr("top.yaml:3:3: error: `robots` has no entry called `qaud`; did you mean "
                "`quad`? (a map changes existing entries; to add one, write the whole list)"));
}

TEST(Include, AMapReplacesAListWithoutNamesForTheReaderToJudge) {
  const TempFolder folder;
  folder.write("base.yaml", "a: [0, 0, 1]\n");
  folder.write("top.yaml", "include: base.yaml\na: {z: 2}\n");
  Diagnostics diagnostics;
  const auto root = load_config(folder.path("top.yaml"), diagnostics);
  ASSERT_TRUE(root.has_value()) << diagnostics.to_string();
  EXPECT_EQ(root->find("a")->find("z")->scalar, "2");
}

TEST(Include, IsRelativeToTheIncludingFile) {
  TempFolder folder;
  folder.write("sub/inner.yaml", "include: ../base.yaml\nb: 2\n");
  folder.write("base.yaml", "a: 1\n");
  Diagnostics diagnostics;
  const auto root = load_config(folder.write("top.yaml", "include: sub/inner.yaml\n"), diagnostics);
  ASSERT_TRUE(root.has_value()) << diagnostics.to_string();
  EXPECT_EQ(root->keys(), (std::vector<std::string>{"a", "b"}));
}

TEST(Include, CycleShowsItsChain) {
  TempFolder folder;
  folder.write("b.yaml", "include: a.yaml\n");
  const std::string a = folder.write("a.yaml", "include: b.yaml\n");
  Diagnostics diagnostics;
  EXPECT_FALSE(load_config(a, diagnostics).has_value());
  EXPECT_THAT(diagnostics.to_string(),
              HasSubstr("cyclic include: " + a + " -> " + folder.path("b.yaml") + " -> " + a));
}

TEST(Include, TakesAShippedScenarioWhereNoFileHasTheName) {
  for (const char* name : {"hover", "hover.yaml"}) {
    TempFolder folder;
    const std::string top = folder.write("top.yaml", std::string("include: ") + name + "\n");
    Diagnostics diagnostics;
    const auto root = load_config(top, diagnostics);
    ASSERT_TRUE(root) << diagnostics.to_string();
    EXPECT_NE(root->find("robots"), nullptr);
  }
  TempFolder folder;
  folder.write("hover.yaml", "a: 1\n");
  Diagnostics diagnostics;
  const auto root = load_config(folder.write("top.yaml", "include: hover.yaml\n"), diagnostics);
  ASSERT_TRUE(root) << diagnostics.to_string();
  EXPECT_EQ(root->find("robots"), nullptr) << "the file beside it comes first";
}

TEST(Include, TheSameFileTwiceIsNoCycle) {
  TempFolder folder;
  folder.write("base.yaml", "a: 1\n");
  Diagnostics diagnostics;
  EXPECT_TRUE(
      load_config(folder.write("t.yaml", "include: [base.yaml, base.yaml]\n"), diagnostics));
}

std::string override_result(const std::string& text, const std::string& assignment) {
  ConfigNode root = parse(text);
  Diagnostics diagnostics;
  if (!apply_override(root, assignment, diagnostics)) return diagnostics.to_string();
  return to_yaml(root);
}

TEST(Override, ReachesKeysIndicesAndNames) {
  const std::string text = "robots: [{name: quad, pose: {z: 1}}, {plugin: imu}]\n";
  EXPECT_THAT(override_result(text, "robots[0].pose.z=2"), HasSubstr("z: 2"));
  EXPECT_THAT(override_result(text, "robots.quad.pose.z=[3, 4]"), HasSubstr("z: [3, 4]"));
  EXPECT_THAT(override_result(text, "robots.imu.name=x"), HasSubstr("plugin: imu\n    name: x"));
}

TEST(Override, AddsKeysAndReplacesWholeValues) {
  EXPECT_EQ(override_result("a: {b: 1}\n", "a.c.d=2"), "a:\n  b: 1\n  c:\n    d: 2\n");
  EXPECT_EQ(override_result("a: {b: 1}\n", "a={x: y}"), "a:\n  x: y\n");
}

TEST(Override, NoValueRemovesAKeyOrAnEntryAsInFilesThatIncludeOthers) {
  EXPECT_EQ(override_result("a: 1\nb: 2\n", "a="), "b: 2\n");
  EXPECT_EQ(override_result("a: {b: 1, c: 2}\n", "a.b=~"), "a:\n  c: 2\n");
  EXPECT_EQ(override_result("a: [1, 2, 3]\n", "a[1]=null"), "a: [1, 3]\n");
  EXPECT_EQ(override_result("a: [{name: x}, {name: y}]\n", "a.x=~"), "a:\n  - name: y\n");
}

TEST(Override, NonsenseIsAnErrorThatNamesTheOverride) {
  EXPECT_EQ(override_result("a: 1\n", "a.b=2"),
            "--set a.b=2: error: `a` is the number 1; it has no `b`\n");
  for (const char* bad : {"", "=1", "a", ".a=1", "a.=1", "a..b=1", "[0]=1", "a[x]=1", "a[0]b=1",
                          "a[-1]=1", "a[99999999999]=1"}) {
    EXPECT_THAT(override_result("a: [1]\n", bad), HasSubstr("error")) << bad;
  }
}

TEST(Override, AmbiguousNameIsAnError) {
  EXPECT_THAT(override_result("a: [{plugin: x}, {plugin: x}]\n", "a.x.name=y"),
              HasSubstr("several"));
}

}  // namespace
}  // namespace skybody
