// Writes a tree as YAML: block maps and block lists of maps, flow style for lists of scalars.
#include <cstdio>

#include "core/io/files/text.h"
#include "core/io/yaml/config_tree.h"

namespace skybody {
namespace {

bool is_plain(const std::string& text) {
  if (text.empty() || text.front() == ' ' || text.back() == ' ') return false;
  const std::string_view first = "!&*-?:,[]{}#|>@`\"'%";
  if (first.find(text[0]) != first.npos && !parse_number(text)) return false;
  for (char c : text) {
    const bool safe =
        c >= ' ' && c < 0x7f && std::string_view(":#,[]{}\"'\\").find(c) == std::string_view::npos;
    if (!safe) return false;
  }
  return true;
}

bool spells_null(const std::string& text) {
  return text == "~" || text == "null" || text == "Null" || text == "NULL";
}

std::string quote(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      char code[8];
      std::snprintf(code, sizeof code, "\\x%02x",
                    static_cast<unsigned>(static_cast<unsigned char>(c)));
      out += code;
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string scalar_text(const ConfigNode& node) {
  if (!node.quoted && is_plain(node.scalar)) return node.scalar;
  return quote(node.scalar);
}

std::string key_text(const std::string& key) {
  return is_plain(key) && !spells_null(key) ? key : quote(key);
}

bool is_flow(const ConfigNode& node) {
  for (const ConfigNode& item : node.items) {
    if (item.is_map() && !item.entries.empty()) return false;
    if (item.is_sequence() && !is_flow(item)) return false;
  }
  return !node.is_map() || node.entries.empty();
}

std::string flow_text(const ConfigNode& node) {
  if (node.is_null()) return "null";
  if (node.is_scalar()) return scalar_text(node);
  if (node.is_map()) return "{}";
  std::vector<std::string> words;
  for (const ConfigNode& item : node.items) words.push_back(flow_text(item));
  return '[' + join(words) + ']';
}

void write(const ConfigNode& node, int indent, bool in_item, std::string& out) {
  const std::string space(static_cast<std::size_t>(indent), ' ');
  bool first = in_item;
  for (const ConfigEntry& entry : node.entries) {
    out += (first ? "" : space) + key_text(entry.key) + ':';
    first = false;
    if (is_flow(entry.value)) {
      out += ' ' + flow_text(entry.value) + '\n';
    } else {
      out += '\n';
      write(entry.value, indent + 2, false, out);
    }
  }
  for (const ConfigNode& item : node.items) {
    out += (first ? "" : space) + "- ";
    first = false;
    if (is_flow(item)) {
      out += flow_text(item) + '\n';
    } else {
      write(item, indent + 2, true, out);
    }
  }
}

}  // namespace

std::string to_yaml(const ConfigNode& node) {
  if (is_flow(node)) return flow_text(node) + '\n';
  std::string out;
  write(node, 0, false, out);
  return out;
}

}  // namespace skybody
