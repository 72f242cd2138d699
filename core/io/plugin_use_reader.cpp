#include "core/io/plugin_use_reader.h"

#include <unordered_set>

#include "core/io/parameter_reader.h"
#include "core/io/scenario_fields.h"
#include "core/io/text.h"

namespace skybody {
namespace {

/// Plugins that are no longer there, and what does their work.
struct Retired {
  SkybodyKind kind;
  const char *name, *remedy;
};
constexpr Retired kRetired[] = {
    {SKYBODY_RANDOMIZER, "uniform",
     "`draw` does its work: `paths` is `what` there, and `scale` and `shift` are `range` with "
     "`form: scale` or `form: shift`"},
    {SKYBODY_RANDOMIZER, "inertia", "`vehicle_constants` does its work"},
};

std::string remedy_of(const PluginUse& use, SkybodyKind kind) {
  for (const Retired& r : kRetired) {
    if (r.kind == kind && use.plugin == r.name) return r.remedy;
  }
  return {};
}

/// The declaration that `use` names, or null and an error where it is written.
const PluginDeclaration* find_plugin(const PluginUse& use, SkybodyKind kind,
                                     const PluginCatalog& catalog, Diagnostics& diagnostics) {
  const std::string what = std::string(kind_name(kind)) + " `" + use.plugin + "`";
  const PluginDeclaration* found = catalog.find(kind, use.plugin);
  if (found == nullptr && !remedy_of(use, kind).empty()) {
    diagnostics.error(use.mark, "the " + what + " is retired: " + remedy_of(use, kind));
    return nullptr;
  }
  if (found == nullptr) {
    const std::string hint = suggestion(use.plugin, catalog.names(kind), "found");
    const bool is_slip = hint.find("did you mean") != std::string::npos;
    const char* more = "; more folders: --plugin-path, plugin_path or SKYBODY_PLUGIN_PATH";
    diagnostics.error(use.mark, "unknown " + what + hint + (is_slip ? "" : more));
    return nullptr;
  }
  if (!found->failure.empty()) {
    diagnostics.error(use.mark, "the " + what + " cannot be used: " + found->failure);
    return nullptr;
  }
  return found;
}

}  // namespace

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
