#include "core/assemble/load.h"

#include <map>
#include <utility>

#include "core/base/fp_environment.h"
#include "core/base/isa.h"
#include "core/io/scenario_reader.h"
#include "core/io/shipped_files.h"
#include "core/io/text.h"
#include "core/model/marked_error.h"
#include "core/physics/stepper.h"
#include "plugins/host/instance.h"
#include "plugins/host/registry.h"

namespace skybody {
namespace {

SkybodyKind to_c(PluginKind kind) { return static_cast<SkybodyKind>(kind); }

/// The registry in the scenario reader's terms.
class RegistryCatalog : public PluginCatalog {
 public:
  explicit RegistryCatalog(std::shared_ptr<const PluginRegistry> registry)
      : registry_(std::move(registry)) {}

  const PluginDeclaration* find(PluginKind kind, const std::string& name) const override {
    const PluginEntry* entry = registry_->find(to_c(kind), name);
    if (entry == nullptr) return nullptr;
    auto [place, fresh] = declarations_.try_emplace({static_cast<int>(kind), name});
    if (fresh) {
      place->second = {kind,           entry->name,      entry->doc, entry->file.string(),
                       entry->failure, entry->parameters};
    }
    return &place->second;
  }

  std::vector<std::string> names(PluginKind kind) const override {
    return registry_->names(to_c(kind));
  }

 private:
  std::shared_ptr<const PluginRegistry> registry_;
  mutable std::map<std::pair<int, std::string>, PluginDeclaration> declarations_;
};

/// Makes instances from the registry's libraries.
class RegistryFactory : public PluginFactory {
 public:
  explicit RegistryFactory(const PluginRegistry& registry) : registry_(registry) {}

  Made make(SkybodyKind kind, const std::string& plugin, const SkybodySetup& setup,
            const SkybodyDeclare& declare) override {
    const PluginEntry& entry = require(kind, plugin);
    return {create_instance(entry, setup, declare), entry.descriptor,
            kernels_for(*entry.descriptor, best_isa())};
  }

  std::vector<Randomizable> randomizable(SkybodyKind kind, const std::string& plugin) override {
    std::vector<Randomizable> list;
    for (const ParameterSpec& p : require(kind, plugin).parameters) {
      if (p.randomizable) list.push_back({p.name, p.unit, p.min, p.max});
    }
    return list;
  }

 private:
  const PluginEntry& require(SkybodyKind kind, const std::string& plugin) const {
    const PluginEntry* entry = registry_.find(kind, plugin);
    if (entry == nullptr || !entry->failure.empty()) {
      throw Error("plugin `" + plugin + "` is not to be had");  // the scenario reader has said why
    }
    return *entry;
  }
  const PluginRegistry& registry_;
};

/// The file that `scenario` means: itself, or a shipped scenario's name, which a folder does not
/// hide (`--out boom` makes one).
std::string scenario_file(const std::string& scenario) {
  std::error_code ignored;
  if (!std::filesystem::exists(scenario, ignored) ||
      std::filesystem::is_directory(scenario, ignored)) {
    if (const auto shipped = find_shipped_scenario(scenario)) return shipped->string();
  }
  return scenario;
}

/// Whether `scenario` is there; if not, and it looks like a name, the error says which names are.
bool check_name(const std::string& scenario, Diagnostics& diagnostics) {
  std::error_code ignored;
  if (!is_identifier(scenario) || std::filesystem::exists(scenario_file(scenario), ignored)) {
    return true;
  }
  diagnostics.error({scenario, 0, 0}, "neither a file nor a shipped scenario" +
                                          suggestion(scenario, shipped_scenarios(), "shipped"));
  return false;
}

}  // namespace

std::shared_ptr<PluginRegistry> find_plugins(const LoadOptions& options) {
  std::vector<std::filesystem::path> path = options.plugin_path;
  const std::filesystem::path folder =
      std::filesystem::path(scenario_file(options.scenario)).parent_path();
  for (auto& place : default_search_path(folder)) path.push_back(std::move(place));
  return std::make_shared<PluginRegistry>(path);
}

std::unique_ptr<PluginCatalog> make_catalog(std::shared_ptr<const PluginRegistry> registry) {
  return std::make_unique<RegistryCatalog>(std::move(registry));
}

std::shared_ptr<const Environment> load_environment(const LoadOptions& options,
                                                    Diagnostics& diagnostics) {
  if (!check_name(options.scenario, diagnostics)) return nullptr;
  return load_environment(options, find_plugins(options), diagnostics);
}

std::shared_ptr<const Environment> load_environment(
    const LoadOptions& options, const std::shared_ptr<const PluginRegistry>& registry,
    Diagnostics& diagnostics) {
  const FpEnvironment guard;
  const auto catalog = make_catalog(registry);
  std::optional<Scenario> scenario =
      read_scenario(scenario_file(options.scenario), options.overrides, *catalog, diagnostics);
  if (!scenario || diagnostics.has_errors()) return nullptr;
  const SourceMark whole{scenario->file, 0, 0};
  try {
    RegistryFactory factory(*registry);
    auto environment =
        std::make_shared<const Environment>(std::make_unique<World>(std::move(*scenario)), factory);
    check_world(environment->world());  // a world that cannot be built is said here
    return environment;
  } catch (const MarkedError& e) {
    diagnostics.error(e.mark(), e.what());
  } catch (const Error& e) {
    diagnostics.error(whole, e.what());
  }
  return nullptr;
}

std::shared_ptr<const Environment> load_environment(const LoadOptions& options) {
  Diagnostics diagnostics;
  auto environment = load_environment(options, diagnostics);
  diagnostics.throw_if_errors();
  return environment;
}

}  // namespace skybody
