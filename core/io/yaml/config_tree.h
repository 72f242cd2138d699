// A YAML document as a tree whose keys and values carry their source locations.
//
// Keys keep their order. Anchors and aliases are expanded, duplicate keys are errors. Files can
// include others, and the command line can override single values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/io/files/input_budget.h"
#include "core/io/yaml/diagnostics.h"

namespace skybody {

struct ConfigEntry;

/// One value: null, scalar, sequence or map.
struct ConfigNode {
  enum class Kind { kNull, kScalar, kSequence, kMap };

  Kind kind = Kind::kNull;
  SourceLocation mark;
  std::string scalar;                ///< text of a scalar, unquoted
  bool quoted = false;               ///< the scalar was quoted: always a text
  std::vector<ConfigNode> items;     ///< of a sequence
  std::vector<ConfigEntry> entries;  ///< of a map, in the order of the file

  bool is_null() const { return kind == Kind::kNull; }
  bool is_scalar() const { return kind == Kind::kScalar; }
  bool is_sequence() const { return kind == Kind::kSequence; }
  bool is_map() const { return kind == Kind::kMap; }

  /// The value of `key` in a map, or null.
  const ConfigNode* find(const std::string& key) const;
  ConfigNode* find(const std::string& key);
  /// The keys of a map.
  std::vector<std::string> keys() const;
  /// The node's description for messages: "a map", "a list", "the number 3", "the text `abc`",
  /// "a text, \"3\"" for a number in quotes.
  std::string describe() const;
};

/// A key of a map with its value.
struct ConfigEntry {
  std::string key;
  SourceLocation key_mark;
  ConfigNode value;
};

/// Whether messages may quote a file that is not a map of keys and values. Files named in a
/// scenario (by `include`, `rotors`) are not quoted: the name may point to any file of the system.
enum class Quoting { kNo, kYes };

/// The cost of a tree against an InputBudget, and its number of levels.
struct ConfigCost {
  long values = 0;
  std::size_t bytes = 0;
  int depth = 0;
};
ConfigCost cost_of(const ConfigNode& node);

/// "the YAML holds more than ...", for messages about an exhausted budget.
std::string too_many_values();
/// "the files hold more than ...", for messages about an exhausted budget.
std::string too_much_text();

/// Parses YAML. Locations name `file`; they have no position if `file` starts with "--set".
/// Returns nullopt and an error for bad syntax, duplicate keys, several documents, too many levels,
/// or an exhausted `budget`. Each use of an alias counts in full.
std::optional<ConfigNode> parse_yaml(const std::string& text, const std::string& file,
                                     Diagnostics& diagnostics, InputBudget& budget,
                                     Quoting quoting = Quoting::kYes);

/// The same with a budget of its own.
std::optional<ConfigNode> parse_yaml(const std::string& text, const std::string& file,
                                     Diagnostics& diagnostics);

/// Reads `file` and the files of its top-level key `include` (a file or a list of files, relative
/// to the including file). Later files override earlier ones, and the including file overrides all.
/// Maps are merged deeply, entries of lists by name; all other values are replaced. A file that is
/// included several times is read once.
/// Returns nullopt and errors if a file is missing, invalid or includes itself, or if `budget` is
/// exhausted.
std::optional<ConfigNode> load_config(const std::string& file, Diagnostics& diagnostics,
                                      InputBudget& budget, Quoting quoting = Quoting::kYes);

/// The same with a budget of its own.
std::optional<ConfigNode> load_config(const std::string& file, Diagnostics& diagnostics);

/// The name of a list's entry, or else its plugin's name; empty if it has neither.
const std::string& name_of(const ConfigNode& item);

/// The entry of a list called `name`. Null and an error if there is none or several; the error
/// calls the list `path`.
/// @param advice  end of the message if there is none
ConfigNode* entry_called(ConfigNode& list, const std::string& name, const std::string& path,
                         const SourceLocation& mark, Diagnostics& diagnostics,
                         const std::string& advice = "");

/// Merges `over` into `base`. A map merged into a list of named entries patches the entries named
/// by its keys. A key without a value (`~`) removes the key from `base`, as in JSON merge patches
/// (RFC 7396).
/// @param path  path of both, for messages
/// @returns false after errors
bool merge_config(ConfigNode& base, const ConfigNode& over, Diagnostics& diagnostics,
                  const std::string& path = "");

/// Applies `PATH=VALUE`. PATH is like `robots[0].controllers[0].plugin`, `task.horizon` or
/// `robots.quad.pose.position` (entries of a list by their name, or by their plugin's name); VALUE
/// is YAML. A missing key is added; the reader checks it later. The location of errors is the
/// override's text. Returns whether the override was applied.
bool apply_override(ConfigNode& root, const std::string& assignment, Diagnostics& diagnostics,
                    InputBudget& budget);
bool apply_override(ConfigNode& root, const std::string& assignment, Diagnostics& diagnostics);

/// Writes the tree as YAML that parses to the same tree.
std::string to_yaml(const ConfigNode& node);

}  // namespace skybody
