#include <algorithm>
#include <filesystem>
#include <map>

#include "core/io/files/file.h"
#include "core/io/files/missing_file.h"
#include "core/io/files/shipped_files.h"
#include "core/io/files/text.h"
#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/include_chain.h"

namespace skybody {
namespace {

constexpr const char* kIncludeRemedy =
    "give its path from this file, or the name of a shipped scenario (`skybody scenarios` lists "
    "them)";

/// A file that is being loaded, with the location of the reference to it.
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
  Loader(InputBudget& budget, Diagnostics& diagnostics)
      : budget_(budget), diagnostics_(diagnostics) {}

  /// The file merged with its includes, or null after errors. Owned by the loader.
  ConfigNode* load(const std::string& path, const SourceLocation& used_at, Quoting quoting) {
    const std::string identity = identity_of(path);
    const auto same = [&](const OpenFile& file) { return file.identity == identity; };
    if (std::any_of(chain_.begin(), chain_.end(), same)) {
      diagnostics_.error(used_at, "cyclic include: " + chain_text() + " -> " + path +
                                      "; remove one of these includes");
      return nullptr;
    }
    if (const auto known = loaded_.find(path); known != loaded_.end()) {
      return known->second ? &*known->second : nullptr;
    }
    const std::optional<std::string> text = read_file(path, used_at, diagnostics_);
    if (!text) return nullptr;
    chain_.push_back({path, identity});
    std::optional<ConfigNode> merged = parse(*text, path, used_at, quoting);
    chain_.pop_back();
    std::optional<ConfigNode>& kept = loaded_[path] = std::move(merged);
    return kept ? &*kept : nullptr;
  }

 private:
  std::optional<ConfigNode> parse(const std::string& text, const std::string& path,
                                  const SourceLocation& used_at, Quoting quoting) {
    if (!budget_.take_file(text.size())) {
      diagnostics_.error(used_at.file.empty() ? SourceLocation{path, 0, 0} : used_at,
                         too_much_text());
      return std::nullopt;
    }
    std::optional<ConfigNode> root = parse_yaml(text, path, diagnostics_, budget_, quoting);
    if (!root) return std::nullopt;
    if (root->is_map()) {
      if (quoting == Quoting::kNo && !has_words_for_keys(*root)) return std::nullopt;
      return merge_includes(std::move(*root));
    }
    std::string what = root->is_null() ? "nothing" : root->describe();
    if (root->is_scalar() && quoting == Quoting::kNo) what = "a text";
    diagnostics_.error({path, root->mark.line, root->mark.column},
                       "the file holds " + what + "; a map of keys and values is needed");
    return std::nullopt;
  }

  /// A system file may parse as a map. Its lines must not appear in messages as unknown keys.
  bool has_words_for_keys(const ConfigNode& root) {
    for (const ConfigEntry& entry : root.entries) {
      if (is_identifier(entry.key)) continue;
      diagnostics_.error(entry.key_mark,
                         "this key is no word of letters, digits, '_' and '-': the file is no part "
                         "of a scenario; leave it out");
      return false;
    }
    return true;
  }

  std::string chain_text() const {
    std::vector<std::string> names;
    for (const OpenFile& file : chain_) names.push_back(file.path);
    return join(names, " -> ");
  }

  /// The file names of `include`; an error for values that are not texts.
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
    for (const ConfigNode* file : *files) good = take(*file, merged) && good;
    good = merge_config(merged, own, diagnostics_) && good;
    if (!good) return std::nullopt;
    return merged;
  }

  /// Merges the file called `name` into `merged`.
  bool take(const ConfigNode& name, ConfigNode& merged) {
    if (!budget_.take_include()) {
      diagnostics_.error(name.mark, "more than " + std::to_string(InputBudget::kMostIncludes) +
                                        " files are included; put some into one file");
      return false;
    }
    const std::string path = included_path(name);
    const std::string problem = missing_file(path, kIncludeRemedy, shipped_scenarios());
    if (!problem.empty()) {
      diagnostics_.error(name.mark, problem);
      return false;
    }
    const ConfigNode* node = load(path, name.mark, Quoting::kNo);
    if (node == nullptr) return false;
    const ConfigCost cost = cost_of(*node);
    if (!budget_.take_values(cost.values, cost.bytes)) {
      diagnostics_.error(name.mark, too_many_values());
      return false;
    }
    return merge_config(merged, *node, diagnostics_);
  }

  InputBudget& budget_;
  Diagnostics& diagnostics_;
  std::vector<OpenFile> chain_;
  std::map<std::string, std::optional<ConfigNode>> loaded_;  ///< by path; nullopt: it has errors
};

}  // namespace

std::string too_much_text() {
  return "the files of this scenario hold more than " +
         std::to_string(InputBudget::kMostFileText >> 20) + " MiB of text; leave some out";
}

std::optional<ConfigNode> load_config(const std::string& file, Diagnostics& diagnostics,
                                      InputBudget& budget, Quoting quoting) {
  Loader loader(budget, diagnostics);
  ConfigNode* root = loader.load(file, {}, quoting);
  if (root == nullptr) return std::nullopt;
  return std::move(*root);
}

std::optional<ConfigNode> load_config(const std::string& file, Diagnostics& diagnostics) {
  InputBudget budget;
  return load_config(file, diagnostics, budget);
}

}  // namespace skybody
