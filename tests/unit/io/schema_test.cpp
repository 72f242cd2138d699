#include "core/io/yaml/schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

#include "core/io/files/json.h"
#include "core/io/files/text.h"
#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/scenario_fields.h"
#include "tests/unit/io/fake_catalog.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

using ::testing::HasSubstr;

/// Parses one JSON value (RFC 8259); false at the first violation.
class JsonCheck {
 public:
  explicit JsonCheck(const std::string& text) : text_(text) {}
  bool valid() { return value() && (skip(), at_ == text_.size()); }

 private:
  void skip() {
    while (at_ < text_.size() && std::string(" \n\t\r").find(text_[at_]) != std::string::npos)
      ++at_;
  }
  bool take(char c) {
    skip();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  bool string() {
    if (!take('"')) return false;
    while (at_ < text_.size() && text_[at_] != '"') {
      if (static_cast<unsigned char>(text_[at_]) < 0x20) return false;
      at_ += text_[at_] == '\\' ? 2 : 1;
    }
    return take('"');
  }
  bool list(char close, bool keys) {
    if (take(close)) return true;
    do {
      if (keys && !(string() && take(':'))) return false;
      if (!value()) return false;
    } while (take(','));
    return take(close);
  }
  bool value() {
    skip();
    if (at_ >= text_.size()) return false;
    if (take('{')) return list('}', true);
    if (take('[')) return list(']', false);
    if (text_[at_] == '"') return string();
    const std::size_t end = std::min(text_.find_first_of(",]} \n", at_), text_.size());
    const std::string word = text_.substr(at_, end - at_);
    at_ = end;
    return word == "true" || word == "false" || word == "null" ||
           (word != "inf" && word != "nan" && parse_number(word).has_value());
  }

  const std::string& text_;
  std::size_t at_ = 0;
};

TEST(Schema, IsValidJson) {
  const std::string schema = scenario_schema(FakeCatalog());
  EXPECT_TRUE(JsonCheck(schema).valid());
}

TEST(Schema, HasKeysPluginsUnitsAndRanges) {
  const FakeCatalog catalog;
  Diagnostics diagnostics;
  const auto root = parse_yaml(scenario_schema(catalog), "schema", diagnostics);  // JSON is YAML
  ASSERT_TRUE(root.has_value()) << diagnostics.to_string();
  const ConfigNode& properties = *root->find("properties");
  for (const std::string& name : scenario_fields().names()) {
    EXPECT_NE(properties.find(name), nullptr) << name;
  }
  const ConfigNode& definitions = *root->find("definitions");
  const ConfigNode& dt = *definitions.find("stepping")->find("properties")->find("dt");
  EXPECT_EQ(dt.find("description")->scalar, "physics step [s]");
  EXPECT_EQ(dt.find("default")->scalar, "0.001");
  EXPECT_EQ(dt.find("maximum")->scalar, "0.1");
  const ConfigNode& controller = *definitions.find("controller");
  EXPECT_EQ(controller.find("properties")->find("plugin")->find("enum")->items.size(), 3u);
  EXPECT_EQ(controller.find("allOf")->items.size(), 3u);
  EXPECT_THAT(to_yaml(controller), HasSubstr("max_speed"));
}

TEST(Schema, StringsAreEscaped) { EXPECT_EQ(json_string("a\"b\\c\n"), "\"a\\\"b\\\\c\\u000a\""); }

TEST(Reference, NamesEveryKey) {
  const std::string text = scenario_reference();
  for (const Field& field : robot_fields().fields) {
    EXPECT_THAT(text, HasSubstr("| `" + field.value.name + "` |"));
  }
}

}  // namespace
}  // namespace skybody
