#include <algorithm>
#include <filesystem>

#include "core/io/config_tree.h"
#include "core/io/file.h"
#include "core/io/text.h"

namespace skybody {
namespace {

/// One file under way, and where it was asked for.
struct OpenFile {
  std::string path;
  std::string identity;  ///< canonical path
};

std::string identity_of(const std::string& path) {
  std::error_code code;
  const auto canonical = std::filesystem::weakly_canonical(path, code);
  return code ? path : canonical.string();
}

class Loader {
 public:
  explicit Loader(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  std::optional<ConfigNode> load(const std::string& path, const SourceMark& used_at) {
    const std::string identity = identity_of(path);
    const auto same = [&](const OpenFile& file) { return file.identity == identity; };
    if (std::any_of(chain_.begin(), chain_.end(), same)) {
      diagnostics_.error(used_at, "cyclic include: " + chain_text() + " -> " + path +
                                      "; remove one of these includes");
      return std::nullopt;
    }
    const std::optional<std::string> text = read_file(path, used_at, diagnostics_);
    if (!text) return std::nullopt;
    std::optional<ConfigNode> root = parse_yaml(*text, path, diagnostics_);
    if (!root) return std::nullopt;
    if (!root->is_map()) {
      diagnostics_.error({path, root->mark.line, root->mark.column},
                         "the file holds " + (root->is_null() ? "nothing" : root->describe()) +
                             "; a map of keys and values is needed");
      return std::nullopt;
    }
    chain_.push_back({path, identity});
    std::optional<ConfigNode> merged = merge_includes(std::move(*root));
    chain_.pop_back();
    return merged;
  }

 private:
  std::string chain_text() const {
    std::vector<std::string> names;
    for (const OpenFile& file : chain_) names.push_back(file.path);
    return join(names, " -> ");
  }

  /// The files that `include` names; an error for what is not text.
  std::optional<std::vector<const ConfigNode*>> included(const ConfigNode& include) {
    std::vector<const ConfigNode*> files;
    if (include.is_scalar()) files.push_back(&include);
    for (const ConfigNode& item : include.items) files.push_back(&item);
    bool good = include.is_scalar() || include.is_sequence();
    if (!good) diagnostics_.error(include.mark, include_error(include));
    for (const ConfigNode* file : files) {
      if (file->is_scalar() && !file->scalar.empty()) continue;
      diagnostics_.error(file->mark, include_error(*file));
      good = false;
    }
    if (!good) return std::nullopt;
    return files;
  }

  static std::string include_error(const ConfigNode& node) {
    return "`include` is " + node.describe() + "; allowed: a file or a list of files";
  }

  std::optional<ConfigNode> merge_includes(ConfigNode own) {
    const auto include = std::find_if(own.entries.begin(), own.entries.end(),
                                      [](const ConfigEntry& e) { return e.key == "include"; });
    if (include == own.entries.end()) return own;
    const ConfigNode list = include->value;
    own.entries.erase(include);
    const auto files = included(list);
    if (!files) return std::nullopt;
    ConfigNode merged;
    merged.kind = ConfigNode::Kind::kMap;
    bool good = true;
    for (const ConfigNode* file : *files) {
      const std::string path = resolve_path(file->scalar, file->mark);
      const std::optional<ConfigNode> node = load(path, file->mark);
      if (node) merge_config(merged, *node);
      good = good && node.has_value();
    }
    merge_config(merged, own);
    if (!good) return std::nullopt;
    return merged;
  }

  Diagnostics& diagnostics_;
  std::vector<OpenFile> chain_;
};

}  // namespace

std::optional<ConfigNode> load_config(const std::string& file, Diagnostics& diagnostics) {
  return Loader(diagnostics).load(file, {});
}

}  // namespace skybody
