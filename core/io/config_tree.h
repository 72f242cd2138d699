// A YAML document as a tree in which every key and value knows where it was written.
//
// Keys keep their order. Anchors and aliases are expanded, duplicate keys are errors. Files can
// include others, and single values can be overridden from the command line.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/io/diagnostics.h"
#include "core/io/input_budget.h"

namespace skybody {

struct ConfigEntry;

/// One value: null, scalar, sequence or map.
struct ConfigNode {
  enum class Kind { kNull, kScalar, kSequence, kMap };

  Kind kind = Kind::kNull;
  SourceLocation mark;
  std::string scalar;                ///< text of a scalar, unquoted
  bool quoted = false;               ///< the scalar was quoted: it is text whatever it spells
  std::vector<ConfigNode> items;     ///< of a sequence
  std::vector<ConfigEntry> entries;  ///< of a map, in the order in which they were written

  bool is_null() const { return kind == Kind::kNull; }
  bool is_scalar() const { return kind == Kind::kScalar; }
  bool is_sequence() const { return kind == Kind::kSequence; }
  bool is_map() const { return kind == Kind::kMap; }

  /// The value of `key` in a map, or null.
  const ConfigNode* find(const std::string& key) const;
  ConfigNode* find(const std::string& key);
  /// The keys of a map.
  std::vector<std::string> keys() const;
  /// What the node is, for messages: "a map", "a list", "the number 3", "the text `abc`",
  /// "a text, \"3\"" for a number in quotes.
  std::string describe() const;
};

/// A key of a map with its value.
struct ConfigEntry {
  std::string key;
  SourceLocation key_mark;
  ConfigNode value;
};

/// Whether messages may quote a file that turns out not to be a map of keys and values. Files that
/// a scenario names (by `include`, `rotors`) are not quoted: they may be any file of the system.
enum class Quoting { kNo, kYes };

/// What a tree costs of an InputBudget, and how many levels it has.
struct ConfigCost {
  long values = 0;
  std::size_t bytes = 0;
  int depth = 0;
};
ConfigCost cost_of(const ConfigNode& node);

/// "the YAML holds more than ...", for messages about a budget that is spent.
std::string too_many_values();
/// "the files hold more than ...", likewise.
std::string too_much_text();

/// Parses YAML. Marks name `file`; with `file` starting "--set" they carry no position. Nothing and
/// an error on bad syntax, duplicate keys, several documents, too many levels, or where `budget` is
/// spent; aliases count with all that they repeat.
std::optional<ConfigNode> parse_yaml(const std::string& text, const std::string& file,
                                     Diagnostics& diagnostics, InputBudget& budget,
                                     Quoting quoting = Quoting::kYes);

/// The same with a budget of its own.
std::optional<ConfigNode> parse_yaml(const std::string& text, const std::string& file,
                                     Diagnostics& diagnostics);

/// Reads `file` and what it includes by its top-level key `include` (a file or a list of files,
/// relative to the including file). Later files override earlier ones and the including file
/// overrides all: maps are merged deeply, entries of lists by their name, everything else is
/// replaced. Nothing and errors where a
/// file is missing, broken or includes itself, or where `budget` is spent. A file that is included
/// several times is read once.
std::optional<ConfigNode> load_config(const std::string& file, Diagnostics& diagnostics,
                                      InputBudget& budget, Quoting quoting = Quoting::kYes);

/// The same with a budget of its own.
std::optional<ConfigNode> load_config(const std::string& file, Diagnostics& diagnostics);

/// What an entry of a list is called: its name, or else its plugin; empty: nothing.
const std::string& name_of(const ConfigNode& item);

/// The entry of a list that is called `name`. Null and an error, which calls the list `path`, where
/// there is none or several.
ConfigNode* entry_called(ConfigNode& list, const std::string& name, const std::string& path,
                         const SourceLocation& mark, Diagnostics& diagnostics);

/// Merges `over` into `base`. A map over a list of named entries patches those that its keys name.
/// A key without a value (`~`) removes what `base` has under it, as in JSON merge patches (RFC
/// 7396).
/// @param path  of both, for messages
/// @returns false after errors
bool merge_config(ConfigNode& base, const ConfigNode& over, Diagnostics& diagnostics,
                  const std::string& path = "");

/// Applies `PATH=VALUE`, where PATH is like `robots[0].controllers[0].plugin`, `task.horizon` or
/// `robots.quad.pose.position` (entries of a list by their name, or by their plugin's name) and
/// VALUE is YAML. A key that is not there yet is added, for the reader to judge. Errors are marked
/// with the override's text. Returns whether it was applied.
bool apply_override(ConfigNode& root, const std::string& assignment, Diagnostics& diagnostics,
                    InputBudget& budget);
bool apply_override(ConfigNode& root, const std::string& assignment, Diagnostics& diagnostics);

/// Writes the tree as YAML that reads back as the same tree.
std::string to_yaml(const ConfigNode& node);

}  // namespace skybody
