// Uses yaml-cpp's parser events, since its own tree loses the locations of keys and drops
// duplicates. Event marks count lines and columns from 0. Algorithm: a stack of open containers; a
// map on top alternates between keys and values. Nodes with an anchor are stored by id and copied
// for each alias.
#include <yaml-cpp/anchor.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "core/io/files/file.h"
#include "core/io/yaml/config_tree.h"

namespace skybody {
namespace {

/// Ends the parsing after a reported error; later events cannot help.
struct Stop {};

class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(std::string file, InputBudget& budget, Diagnostics& diagnostics)
      : file_(std::move(file)),
        positions_(!is_from_command_line(file_)),
        budget_(budget),
        diagnostics_(diagnostics) {
    root_.mark = {file_, 0, 0};  // for a text without a document
  }

  ConfigNode take_root() { return std::move(root_); }

  SourceLocation to_mark(const YAML::Mark& mark) const {
    if (!positions_ || mark.is_null()) return {file_, 0, 0};
    return {file_, mark.line + 1, mark.column + 1};
  }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ == 0) root_.mark = to_mark(mark);
    if (documents_ == 2) fail(to_mark(mark), "a second document starts here; one is allowed");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    ConfigNode node;
    node.mark = to_mark(mark);
    add(std::move(node), anchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    check_tag(tag, mark);
    ConfigNode node;
    node.kind = ConfigNode::Kind::kScalar;
    node.mark = to_mark(mark);
    node.scalar = value;
    node.quoted = tag == "!";
    add(std::move(node), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end())
      fail(to_mark(mark), "the alias refers to a value that contains it");
    take(found->second.cost, mark);
    check_depth(static_cast<int>(stack_.size()) + found->second.cost.depth, mark);
    insert(found->second.node);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    check_tag(tag, mark);
    open(ConfigNode::Kind::kSequence, mark, anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    check_tag(tag, mark);
    open(ConfigNode::Kind::kMap, mark, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    ConfigNode node;
    YAML::anchor_t anchor = 0;
    bool has_key = false;
    bool drop_value = false;  ///< the key was rejected: its value is dropped
    ConfigEntry pending;
    std::unordered_map<std::string, std::size_t> places;  ///< indices of the entries by key
  };
  struct Anchored {
    ConfigNode node;
    ConfigCost cost;
  };

  [[noreturn]] void fail(const SourceLocation& mark, const std::string& message) {
    diagnostics_.error(mark, message);
    throw Stop();
  }

  /// Rejects tags such as !!float, which set a value's type: here the key determines the type.
  /// yaml-cpp gives plain values the tag "?" and quoted ones "!".
  void check_tag(const std::string& tag, const YAML::Mark& mark) {
    if (tag.empty() || tag == "?" || tag == "!") return;
    const std::string standard = "tag:yaml.org,2002:";
    const bool is_standard = tag.compare(0, standard.size(), standard) == 0;
    fail(to_mark(mark), "the tag `" + (is_standard ? "!!" + tag.substr(standard.size()) : tag) +
                            "`; tags are not allowed: write the value alone");
  }

  void take(const ConfigCost& cost, const YAML::Mark& mark) {
    if (!budget_.take_values(cost.values, cost.bytes)) fail(to_mark(mark), too_many_values());
  }

  void check_depth(int depth, const YAML::Mark& mark) {
    if (depth <= InputBudget::kDeepest) return;
    fail(to_mark(mark), "maps and lists are nested more than " +
                            std::to_string(InputBudget::kDeepest) +
                            " levels deep here; take levels out");
  }

  void open(ConfigNode::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    check_depth(static_cast<int>(stack_.size()) + 1, mark);
    Open level;
    level.node.kind = kind;
    level.node.mark = to_mark(mark);
    level.anchor = anchor;
    stack_.push_back(std::move(level));
  }

  void close() {
    Open level = std::move(stack_.back());
    stack_.pop_back();
    add(std::move(level.node), level.anchor);
  }

  /// Adds a value; one with an anchor is also stored for its aliases.
  void add(ConfigNode node, YAML::anchor_t anchor) {
    const ConfigCost own{1, node.scalar.size() + file_.size(), 0};
    if (!budget_.take_values(own.values, own.bytes)) fail(node.mark, too_many_values());
    if (anchor != 0) {
      const ConfigCost cost = cost_of(node);
      if (!budget_.take_values(cost.values, cost.bytes)) fail(node.mark, too_many_values());
      anchors_[anchor] = {node, cost};
    }
    insert(std::move(node));
  }

  void insert(ConfigNode node) {
    if (stack_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& top = stack_.back();
    if (top.node.is_sequence()) {
      top.node.items.push_back(std::move(node));
    } else if (!top.has_key) {
      take_key(top, node);
    } else {
      top.pending.value = std::move(node);
      if (!top.drop_value) top.node.entries.push_back(std::move(top.pending));
      top.has_key = false;
    }
  }

  void take_key(Open& top, const ConfigNode& node) {
    top.has_key = true;
    top.drop_value = false;
    top.pending = ConfigEntry{node.scalar, node.mark, {}};
    if (!node.is_scalar()) {
      diagnostics_.error(node.mark, "a key must be a word, not " + node.describe());
      top.drop_value = true;
      return;
    }
    const auto [known, is_new] = top.places.emplace(node.scalar, top.node.entries.size());
    if (is_new) return;
    const SourceLocation& first = top.node.entries[known->second].key_mark;
    diagnostics_.error(node.mark, "duplicate key `" + node.scalar + "`; it stands at " +
                                      to_string(first) + " already; remove one");
    top.drop_value = true;
  }

  std::string file_;
  bool positions_;
  InputBudget& budget_;
  Diagnostics& diagnostics_;
  ConfigNode root_;
  std::vector<Open> stack_;
  std::map<YAML::anchor_t, Anchored> anchors_;
  int documents_ = 0;
};

/// yaml-cpp's message. Some of its messages end with a colon and a part of the file.
std::string message_of(const YAML::Exception& error, Quoting quoting) {
  if (quoting == Quoting::kYes) return error.msg;
  return error.msg.substr(0, error.msg.find(':'));
}

/// A hint for lines with a path such as rotors[0], whose bracket ends a word in a flow list.
/// @param line  from 0
std::string hint_of(const std::string& text, int line) {
  std::istringstream stream(text);
  std::string row;
  for (int i = 0; i <= line; ++i) std::getline(stream, row);
  for (std::size_t at = row.find('['); at != row.npos; at = row.find('[', at + 1)) {
    const bool is_index =
        at > 0 && at + 1 < row.size() &&
        std::isalpha(static_cast<unsigned char>(row[at - 1])) != 0 &&
        (std::isdigit(static_cast<unsigned char>(row[at + 1])) != 0 || row[at + 1] == '*');
    if (is_index) return "; quote names with brackets: \"rotors[0]\"";
  }
  return "";
}

void parse(const std::string& text, TreeBuilder& builder) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  while (parser.HandleNextDocument(builder)) {
  }
}

}  // namespace

std::optional<ConfigNode> parse_yaml(const std::string& text, const std::string& file,
                                     Diagnostics& diagnostics, InputBudget& budget,
                                     Quoting quoting) {
  Diagnostics found;
  TreeBuilder builder(file, budget, found);
  // yaml-cpp treats a NUL in any text as the start of an escape.
  if (const std::size_t nul = text.find('\0'); nul != text.npos) {
    const auto lines =
        std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n');
    const bool has_lines = !is_from_command_line(file);
    const std::size_t line_end = nul == 0 ? text.npos : text.rfind('\n', nul - 1);
    const std::size_t column = line_end == text.npos ? nul + 1 : nul - line_end;
    const SourceLocation mark{file, static_cast<int>(lines) + 1, static_cast<int>(column)};
    diagnostics.error(has_lines ? mark : SourceLocation{file, 0, 0},
                      "not YAML: a NUL character, as in files that are no text; remove it, or give "
                      "a text file");
    return std::nullopt;
  }
  try {
    parse(text, builder);
    if (!found.has_errors()) return builder.take_root();
  } catch (const Stop&) {
  } catch (const YAML::Exception& error) {
    // Earlier messages may quote a file that is not YAML.
    if (quoting == Quoting::kNo) found = Diagnostics();
    found.error(builder.to_mark(error.mark),
                "not YAML: " + message_of(error, quoting) + hint_of(text, error.mark.line));
  }
  diagnostics.add(found);
  return std::nullopt;
}

std::optional<ConfigNode> parse_yaml(const std::string& text, const std::string& file,
                                     Diagnostics& diagnostics) {
  InputBudget budget;
  return parse_yaml(text, file, diagnostics, budget);
}

}  // namespace skybody
