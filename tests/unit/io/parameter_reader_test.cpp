#include "core/io/yaml/parameter_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>

#include "core/io/files/text.h"

namespace skybody {
namespace {

using ::testing::HasSubstr;

ParameterSpec spec(const std::string& name, ParameterType type) {
  ParameterSpec s;
  s.name = name;
  s.type = type;
  s.unit = "m";
  s.doc = "a length";
  s.default_numbers = {0.5};
  s.min = 0.0;
  s.max = 10.0;
  return s;
}

struct Read {
  std::vector<ParameterValue> values;
  std::string messages;
};

Read read(const std::vector<ParameterSpec>& specs, const std::string& yaml) {
  Diagnostics diagnostics;
  const auto node = parse_yaml(yaml, "x.yaml", diagnostics);
  Read result;
  result.values = read_parameters(*node, specs, diagnostics);
  result.messages = diagnostics.to_string();
  return result;
}

TEST(Parameters, DefaultsAreFilledInInTheOrderOfTheSpecs) {
  const Read r = read({spec("a", ParameterType::kReal), spec("b", ParameterType::kReal)}, "{b: 3}");
  EXPECT_EQ(r.messages, "");
  ASSERT_EQ(r.values.size(), 2u);
  EXPECT_EQ(r.values[0].numbers, std::vector<double>{0.5});
  EXPECT_EQ(r.values[1].numbers, std::vector<double>{3.0});
  EXPECT_EQ(r.values[1].mark.column, 5);
}

TEST(Parameters, NamesOfFilesStartAtTheFolderOfTheFileThatHoldsThem) {
  ParameterSpec s = spec("table", ParameterType::kText);
  s.default_numbers = {};
  s.default_texts = {"none"};
  s.is_file = true;
  const auto value = [&](const std::string& yaml, const std::string& file) {
    Diagnostics diagnostics;
    const auto node = parse_yaml(yaml, file, diagnostics);
    return read_parameters(*node, {s}, diagnostics).at(0).texts.at(0);
  };
  EXPECT_EQ(value("{table: a.csv}", "far/off/x.yaml"), "far/off/a.csv");
  EXPECT_EQ(value("{table: ../a.csv}", "far/off/x.yaml"), "far/a.csv");
  EXPECT_EQ(value("{table: /a.csv}", "far/off/x.yaml"), "/a.csv");
  EXPECT_EQ(value("{table: a.csv}", "--set table"), "a.csv");
  EXPECT_EQ(value("{}", "far/off/x.yaml"), "none");
  EXPECT_EQ(read({s}, "{table: [a]}").messages,
            "x.yaml:1:9: error: `table` is a list; allowed: the name of a file\n");
}

TEST(Parameters, NumberAtItsBoundIsAllowed) {
  EXPECT_EQ(read({spec("a", ParameterType::kReal)}, "{a: 10}").messages, "");
  EXPECT_EQ(read({spec("a", ParameterType::kReal)}, "{a: 10.5}").messages,
            "x.yaml:1:5: error: `a` is 10.5; allowed: a number from 0 to 10 m\n");
}

TEST(Parameters, ExclusiveMinimumExcludesItself) {
  ParameterSpec s = spec("a", ParameterType::kReal);
  s.min_exclusive = true;
  EXPECT_EQ(read({s}, "{a: 0}").messages,
            "x.yaml:1:5: error: `a` is 0; allowed: a number above 0, up to 10 m\n");
}

TEST(Parameters, NotFiniteAndNotNumbersAreErrors) {
  const ParameterSpec s = spec("a", ParameterType::kReal);
  for (const char* bad : {"nan", ".nan", ".inf", "-.inf", "1e999", "0x10", "1_0", "\"3\"", "[3]",
                          "{}", "~", "1.2.3", "--1", "true"}) {
    const Read r = read({s}, std::string("{a: ") + bad + "}");
    EXPECT_THAT(r.messages, HasSubstr("error: `a`")) << bad;
    EXPECT_EQ(r.values[0].numbers, std::vector<double>{0.5}) << bad;
  }
}

TEST(Parameters, IntegersMustBeIntegral) {
  const ParameterSpec s = spec("a", ParameterType::kInteger);
  EXPECT_EQ(read({s}, "{a: 3.0}").messages, "");
  EXPECT_THAT(read({s}, "{a: 3.5}").messages, HasSubstr("`a` is 3.5; allowed: an integer"));
}

TEST(Parameters, BooleansAreTrueAndFalseOnly) {
  ParameterSpec s = spec("a", ParameterType::kBoolean);
  EXPECT_EQ(read({s}, "{a: true}").values[0].numbers, std::vector<double>{1.0});
  for (const char* bad : {"yes", "1", "True", "\"true\""}) {
    EXPECT_THAT(read({s}, std::string("{a: ") + bad + "}").messages, HasSubstr("true or false"));
  }
}

TEST(Parameters, TextsAreLimitedToChoices) {
  ParameterSpec s = spec("a", ParameterType::kText);
  s.choices = {"rotors", "body"};
  EXPECT_EQ(read({s}, "{a: body}").values[0].texts, std::vector<std::string>{"body"});
  EXPECT_EQ(read({s}, "{a: rotor}").messages,
            "x.yaml:1:5: error: `a` is `rotor`; allowed: rotors, body; did you mean `rotors`?\n");
}

TEST(Parameters, OneNumberFillsAListOfFixedLengthOnly) {
  ParameterSpec s = spec("a", ParameterType::kReal);
  s.min_count = s.max_count = 3;
  EXPECT_EQ(read({s}, "{a: 2}").values[0].numbers, (std::vector<double>{2, 2, 2}));
  s.max_count = -1;
  s.min_count = 1;
  EXPECT_EQ(
      read({s}, "{a: 2}").messages,
      "x.yaml:1:5: error: `a` is the number 2; allowed: a list of at least 1 numbers from 0 to "
      "10 m\n");
  EXPECT_EQ(read({s}, "{a: [2, 3]}").values[0].numbers, (std::vector<double>{2, 3}));
}

TEST(Parameters, ListNamesTheBadEntry) {
  ParameterSpec s = spec("a", ParameterType::kReal);
  s.min_count = s.max_count = 3;
  EXPECT_EQ(read({s}, "{a: [1, x, 99]}").messages,
            "x.yaml:1:9: error: `a[1]` is the text `x`; allowed: a number from 0 to 10 m\n"
            "x.yaml:1:12: error: `a[2]` is 99; allowed: a number from 0 to 10 m\n");
  EXPECT_THAT(read({s}, "{a: [1]}").messages, HasSubstr("`a` has 1 entry; allowed: a list of 3"));
}

TEST(Parameters, UnknownKeysAndMissingOnesAreErrors) {
  ParameterSpec s = spec("mass", ParameterType::kReal);
  s.required = true;
  const Read r = read({s}, "{mas: 1, zzzzzz: 2}");
  EXPECT_THAT(r.messages, HasSubstr("unknown parameter `mas`; did you mean `mass`?"));
  EXPECT_THAT(r.messages, HasSubstr("unknown parameter `zzzzzz`; parameters: mass"));
  EXPECT_THAT(r.messages, HasSubstr("the parameter `mass` is missing"));
}

TEST(Parameters, TableHasEveryName) {
  EXPECT_THAT(parameter_table({spec("a", ParameterType::kReal)}),
              HasSubstr("| `a` | a number from 0 to 10 m | 0.5 | a length |"));
}

TEST(Text, NumbersDoNotDependOnTheLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  std::setlocale(LC_ALL, "de_DE.UTF-8");  // if it is installed
  EXPECT_EQ(parse_number("2.5"), 2.5);
  EXPECT_EQ(format_number(2.5), "2.5");
  std::setlocale(LC_ALL, before.c_str());
}

TEST(Text, FormattedNumbersReadBackTheSame) {
  for (double value : {0.1, 1e-300, 123456789.0, 1.0 / 3.0, -2e9, 100000.0, 5e-324}) {
    EXPECT_EQ(parse_number(format_number(value)), value);
  }
  EXPECT_EQ(format_number(100000.0), "100000");
}

TEST(Text, ClosestFindsTranspositions) {
  EXPECT_EQ(closest("jiont", {"joint", "point"}), "joint");
  EXPECT_EQ(closest("something", {"joint"}), "");
}

}  // namespace
}  // namespace skybody
