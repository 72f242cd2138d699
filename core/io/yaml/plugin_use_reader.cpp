#include "core/io/yaml/plugin_use_reader.h"

#include <unordered_set>

#include "core/base/system/installation.h"
#include "core/io/files/text.h"
#include "core/io/yaml/parameter_reader.h"
#include "core/io/yaml/scenario_fields.h"

namespace skybody {
namespace {

/// Whether the source tree of this build contains the plugin.
bool is_in_sources(SkybodyKind kind, const std::string& name) {
  const std::filesystem::path folder = shipped_data("", kPluginKinds[kind].folder);
  std::error_code ignored;
  return is_identifier(name) && std::filesystem::exists(folder / name / "README.md", ignored);
}

/// The message about an unknown plugin name.
std::string unknown_plugin(const std::string& name, SkybodyKind kind,
                           const PluginCatalog& catalog) {
  const std::string unknown = "unknown " + std::string(kind_name(kind)) + " `" + name + "`";
  if (const std::string hint = plugin_hint(name, catalog); !hint.empty()) return unknown + hint;
  if (is_in_sources(kind, name)) {
    return unknown + ": it is not built here; `./dev build` makes all plugins";
  }
  const std::vector<std::string> names = catalog.names(kind);
  std::vector<std::string> all = catalog.names_of_any_kind();
  all.insert(all.end(), names.begin(), names.end());
  if (!closest(name, all).empty()) return unknown + suggestion(name, all);
  return unknown + suggestion(name, names, "found") +
         "; more folders: --plugin-path, plugin_path or SKYBODY_PLUGIN_PATH";
}

/// The declaration of the plugin of `use`, or null and an error at its location.
const PluginDeclaration* find_plugin(const PluginUse& use, SkybodyKind kind,
                                     const PluginCatalog& catalog, Diagnostics& diagnostics) {
  const std::string what = std::string(kind_name(kind)) + " `" + use.plugin + "`";
  const PluginDeclaration* found = catalog.find(kind, use.plugin);
  if (found == nullptr) {
    diagnostics.error(use.mark, unknown_plugin(use.plugin, kind, catalog));
    return nullptr;
  }
  if (!found->failure.empty()) {
    diagnostics.error(use.mark, "the " + what + " cannot be used: " + found->failure);
    return nullptr;
  }
  return found;
}

}  // namespace

std::string plugin_hint(const std::string& name, const PluginCatalog& catalog) {
  for (int kind = 0; kind < SKYBODY_KIND_COUNT; ++kind) {
    const auto of_kind = static_cast<SkybodyKind>(kind);
    const std::string article = of_kind == SKYBODY_EFFECT ? "an " : "a ";
    if (catalog.find(of_kind, name) != nullptr)
      return "; `" + name + "` is " + article + kind_name(of_kind);
  }
  return {};
}

PluginUse read_plugin_use(const ConfigNode& node, SkybodyKind kind, const PluginCatalog& catalog,
                          Diagnostics& diagnostics) {
  const MapReader reader(&node, plugin_use_fields(), node.mark, diagnostics);
  PluginUse use;
  use.plugin = reader.text("plugin");
  use.instance = reader.text("name");
  if (use.instance.empty()) use.instance = use.plugin;
  use.mark = reader.mark("plugin");
  if (use.plugin.empty()) return use;
  const PluginDeclaration* declaration = find_plugin(use, kind, catalog, diagnostics);
  if (declaration == nullptr) return use;
  ConfigNode none;
  none.mark = use.mark;
  const ConfigNode* parameters = reader.node("parameters");
  use.parameters = read_parameters(parameters == nullptr ? none : *parameters,
                                   declaration->parameters, diagnostics);
  return use;
}

std::vector<PluginUse> read_plugin_uses(const ConfigNode* node, SkybodyKind kind,
                                        const PluginCatalog& catalog, Diagnostics& diagnostics) {
  std::vector<PluginUse> uses;
  if (node == nullptr || node->is_null()) return uses;
  if (!node->is_sequence()) {
    diagnostics.error(node->mark, std::string(kind_name(kind)) + "s are " + node->describe() +
                                      "; allowed: a list such as [{plugin: NAME}]");
    return uses;
  }
  if (node->items.size() > kMostPluginUses) {
    diagnostics.error(node->mark, too_many_entries(std::string(kind_name(kind)) + "s",
                                                   node->items.size(), kMostPluginUses));
    return uses;
  }
  std::unordered_set<std::string> names;
  for (const ConfigNode& item : node->items) {
    PluginUse use = read_plugin_use(item, kind, catalog, diagnostics);
    if (!use.instance.empty() && !names.insert(use.instance).second) {
      diagnostics.error(use.mark, "a second " + std::string(kind_name(kind)) + " called `" +
                                      use.instance + "`; give it another `name`");
    }
    uses.push_back(std::move(use));
  }
  return uses;
}

}  // namespace skybody
