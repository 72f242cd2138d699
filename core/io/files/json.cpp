#include "core/io/files/json.h"

#include <cstdio>

#include "core/io/files/text.h"

namespace skybody {

std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(c));
      out += code;
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string json_array(const std::vector<std::string>& values) { return '[' + join(values) + ']'; }

JsonObject& JsonObject::set(const std::string& key, std::string value) {
  members_.emplace_back(key, std::move(value));
  return *this;
}

JsonObject& JsonObject::set_text(const std::string& key, std::string_view text) {
  return set(key, json_string(text));
}

JsonObject& JsonObject::add(const JsonObject& other) {
  members_.insert(members_.end(), other.members_.begin(), other.members_.end());
  return *this;
}

std::string JsonObject::text() const {
  std::vector<std::string> parts;
  for (const auto& [key, value] : members_) parts.push_back(json_string(key) + ": " + value);
  return '{' + join(parts) + '}';
}

std::string json_indented(std::string_view json) {
  std::string out;
  std::size_t level = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      out += c;
      if (c == '\\') out += json[++i];
      in_string = c != '"';
      continue;
    }
    if (c == '"') {
      in_string = true;
      out += c;
    } else if (c == '{' && json[i + 1] != '}') {
      out += "{\n" + std::string(2 * ++level, ' ');
    } else if (c == '}' && json[i - 1] != '{') {
      out += '\n' + std::string(2 * --level, ' ') + '}';
    } else if (c == ',' && json[i + 1] == ' ' && json[i + 2] == '"' && out.find('{') != out.npos) {
      // Members of objects get one line each; arrays of words stay on one line.
      std::size_t end = i + 3;
      while (end < json.size() && json[end] != '"') end += json[end] == '\\' ? 2 : 1;
      const bool member = end + 1 < json.size() && json[end + 1] == ':';
      out += member ? ",\n" + std::string(2 * level, ' ') : std::string(", ");
      ++i;
    } else {
      out += c;
    }
  }
  return out + '\n';
}

}  // namespace skybody
