// Needs: yaml-cpp's parser events, since its own tree forgets where keys stand and drops
// duplicates. Assumes: marks of events count lines and columns from 0. Algorithm: a stack of open
// containers; a map on top alternates between keys and values. Nodes with an anchor are kept by id
// and copied where an alias names them.
#include <yaml-cpp/anchor.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <map>
#include <sstream>
#include <utility>

#include "core/io/config_tree.h"
#include "core/io/file.h"

namespace skybody {
namespace {

constexpr int kMostNodes = 1'000'000;

int count_nodes(const ConfigNode& node) {
  int count = 1;
  for (const ConfigNode& item : node.items) count += count_nodes(item);
  for (const ConfigEntry& entry : node.entries) count += count_nodes(entry.value);
  return count;
}

class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(std::string file, Diagnostics& diagnostics)
      : file_(std::move(file)),
        positions_(file_.rfind(kOverridePrefix, 0) != 0),
        diagnostics_(diagnostics) {}

  ConfigNode take_root() { return std::move(root_); }
  bool failed() const { return failed_; }

  SourceMark to_mark(const YAML::Mark& mark) const {
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
    ConfigNode node;
    node.kind = ConfigNode::Kind::kScalar;
    node.mark = to_mark(mark);
    node.scalar = value;
    node.quoted = tag == "!";
    add(std::move(node), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) {
      fail(to_mark(mark), "the alias refers to a value that contains it");
      add(ConfigNode{}, 0);
      return;
    }
    // Too many nodes fail once; nothing is copied from there on.
    node_count_ += found->second.count;
    ConfigNode copy = node_count_ > kMostNodes ? ConfigNode{} : found->second.node;
    add(std::move(copy), 0);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(ConfigNode::Kind::kSequence, mark, anchor);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(ConfigNode::Kind::kMap, mark, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    ConfigNode node;
    YAML::anchor_t anchor = 0;
    bool has_key = false;
    bool drop_value = false;  ///< the key was refused: its value goes nowhere
    ConfigEntry pending;
  };
  struct Anchored {
    ConfigNode node;
    int count = 0;
  };

  void fail(const SourceMark& mark, const std::string& message) {
    if (!failed_) diagnostics_.error(mark, message);
    failed_ = true;
  }

  void open(ConfigNode::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
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

  void add(ConfigNode node, YAML::anchor_t anchor) {
    if (++node_count_ > kMostNodes) {
      fail(node.mark, "aliases expand to more than a million values");
      return;
    }
    if (anchor != 0) anchors_[anchor] = {node, count_nodes(node)};
    if (stack_.empty()) {
      if (documents_ <= 1) root_ = std::move(node);
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
    for (const ConfigEntry& entry : top.node.entries) {
      if (entry.key != node.scalar) continue;
      diagnostics_.error(node.mark, "duplicate key `" + node.scalar + "`; it stands at " +
                                        to_string(entry.key_mark) + " already; remove one");
      top.drop_value = true;
    }
  }

  std::string file_;
  bool positions_;
  Diagnostics& diagnostics_;
  ConfigNode root_;
  std::vector<Open> stack_;
  std::map<YAML::anchor_t, Anchored> anchors_;
  int documents_ = 0;
  long node_count_ = 0;
  bool failed_ = false;
};

}  // namespace

std::optional<ConfigNode> parse_yaml(const std::string& text, const std::string& file,
                                     Diagnostics& diagnostics) {
  const int errors_before = diagnostics.error_count();
  TreeBuilder builder(file, diagnostics);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (!builder.failed() && parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    diagnostics.error(builder.to_mark(error.mark), "not YAML: " + error.msg);
  } catch (const std::exception& error) {
    diagnostics.error({file, 0, 0}, std::string("not YAML: ") + error.what());
  }
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return builder.take_root();
}

}  // namespace skybody
