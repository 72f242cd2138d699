// Builds JSON text from parts, for schemas.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skybody {

/// `text` as a quoted JSON string. Non-ASCII bytes stay as UTF-8.
std::string json_string(std::string_view text);

/// An array of JSON values.
std::string json_array(const std::vector<std::string>& values);

/// A JSON object that keeps the order of its members.
class JsonObject {
 public:
  /// `value` is JSON.
  JsonObject& set(const std::string& key, std::string value);
  JsonObject& set_text(const std::string& key, std::string_view text);
  /// Appends the members of another object.
  JsonObject& add(const JsonObject& other);
  bool empty() const { return members_.empty(); }
  std::string text() const;

 private:
  std::vector<std::pair<std::string, std::string>> members_;
};

/// The same JSON with one member per line, indented by two spaces per level.
std::string json_indented(std::string_view json);

}  // namespace skybody
