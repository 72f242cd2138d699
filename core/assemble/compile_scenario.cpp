#include "core/assemble/compile_scenario.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/assemble/check_plausibility.h"
#include "core/assemble/check_plugin_combinations.h"
#include "core/assemble/check_scenario_name.h"
#include "core/assemble/controller_survey.h"
#include "core/assemble/reference_use.h"
#include "core/assemble/trajectory_chain.h"
#include "core/base/simd/fp_environment.h"
#include "core/base/simd/isa.h"
#include "core/io/files/shipped_files.h"
#include "core/io/files/text.h"
#include "core/io/yaml/plugin_use_reader.h"
#include "core/io/yaml/scenario_reader.h"
#include "core/model/located_error.h"
#include "core/physics/coupling/coupling_start.h"
#include "core/physics/step/group_stepper.h"
#include "core/plugin_host/instance.h"
#include "core/plugin_host/registry.h"

namespace skybody {
namespace {

/// The reason why a library next to the scenario is not opened, and the remedy.
std::string not_searched(const std::filesystem::path& file) {
  const std::string folder = file.parent_path().string();
  return file.string() +
         " lies beside the scenario and is not opened; if you trust it: --trust-scenario, "
         "--plugin-path " +
         folder + " or SKYBODY_PLUGIN_PATH=" + folder + " (in Python plugin_path)";
}

/// Adapts the registry to the scenario reader's interface.
class RegistryCatalog : public PluginCatalog {
 public:
  /// @param beside  plugins next to the scenario that are not searched, see bystanders()
  explicit RegistryCatalog(std::shared_ptr<const PluginRegistry> registry,
                           std::vector<PluginManifest> beside = {})
      : registry_(std::move(registry)), beside_(std::move(beside)) {}

  const PluginDeclaration* find(SkybodyKind kind, const std::string& name) const override {
    const PluginEntry* entry = registry_->find(kind, name);
    if (entry != nullptr) {
      return keep(
          {kind, entry->name, entry->doc, entry->file.string(), entry->failure, entry->parameters});
    }
    for (const PluginManifest& file : beside_) {
      if (!file.promises(name)) continue;
      return keep({kind, name, {}, file.file.string(), not_searched(file.file), {}});
    }
    return nullptr;
  }

  std::vector<std::string> names(SkybodyKind kind) const override { return registry_->names(kind); }
  std::vector<std::string> names_of_any_kind() const override { return registry_->promised(); }

 private:
  const PluginDeclaration* keep(PluginDeclaration&& declaration) const {
    const std::pair key{static_cast<int>(declaration.kind), declaration.name};
    return &declarations_.try_emplace(key, std::move(declaration)).first->second;
  }

  std::shared_ptr<const PluginRegistry> registry_;
  std::vector<PluginManifest> beside_;
  mutable std::map<std::pair<int, std::string>, PluginDeclaration> declarations_;
};

/// Creates instances from the registry's libraries.
class RegistryFactory : public PluginFactory {
 public:
  RegistryFactory(const PluginRegistry& registry, const LoadOptions& options)
      : registry_(registry), options_(options) {}

  Made make(SkybodyKind kind, const std::string& plugin, const SkybodySetup& setup,
            const SkybodyDeclare& declare) override {
    const PluginEntry& entry = require(kind, plugin);
    if (options_.on_setup) options_.on_setup(kind, setup);
    return {create_instance(entry, setup, declare), kernels_for(*entry.descriptor, best_isa()),
            static_cast<int>(entry.descriptor->state_words), entry.file.string(),
            kernels_for(*entry.descriptor, best_isa(), SKYBODY_NUMBER_DUAL)};
  }

  const std::vector<ParameterSpec>& parameters(SkybodyKind kind,
                                               const std::string& plugin) override {
    return require(kind, plugin).parameters;
  }

 private:
  const PluginEntry& require(SkybodyKind kind, const std::string& plugin) const {
    const PluginEntry* entry = registry_.find(kind, plugin);
    if (entry == nullptr || !entry->failure.empty()) {
      throw Error("plugin `" + plugin + "` cannot be used");  // the scenario reader gave the reason
    }
    return *entry;
  }
  const PluginRegistry& registry_;
  const LoadOptions& options_;
};

/// @param who  the source of these folders, for messages
void check_folders(const std::vector<std::filesystem::path>& folders, const std::string& who,
                   Diagnostics& diagnostics) {
  for (const std::filesystem::path& folder : folders) {
    std::error_code ignored;
    const bool is_folder = std::filesystem::is_directory(folder, ignored);
    if (is_folder && folder_problem(folder).empty()) continue;
    diagnostics.error({folder.string(), 0, 0},
                      who + " names this, which is no folder" +
                          std::string(is_folder ? " that can be read" : "") +
                          "; give a folder with plugins, or leave it out");
  }
}

std::vector<std::filesystem::path> folders_beside(const LoadOptions& options) {
  return scenario_plugin_folders(scenario_file(options.scenario));
}

/// Libraries in the scenario's folder and its `plugins` if these folders are not searched.
std::vector<PluginManifest> bystanders(const LoadOptions& options, const PluginRegistry& registry) {
  std::vector<PluginManifest> files;
  for (const std::filesystem::path& folder : folders_beside(options)) {
    const auto same = [&folder](const std::filesystem::path& searched) {
      std::error_code ignored;
      return std::filesystem::equivalent(folder, searched, ignored);
    };
    const auto& path = registry.search_path();
    if (std::any_of(path.begin(), path.end(), same)) continue;
    for (PluginManifest& file : plugin_manifests(folder)) files.push_back(std::move(file));
  }
  return files;
}

/// Text about the controllers that would close a gap in a chain.
std::string bridge(const ChainMismatchError& gap, const PluginRegistry& registry) {
  if (gap.given() == gap.taken()) return "";
  const std::string given = signal_name(gap.given());
  const ControllerSurvey survey =
      survey_controllers(registry.known(SKYBODY_CONTROLLER), survey_vehicle(), 0);
  const std::vector<int> chain = shortest_chain(survey, {gap.given()}, gap.taken());
  if (gap.taken() < 0) {
    return chain.empty() ? "" : ", such as " + chain_text(survey, chain);
  }
  if (!chain.empty()) return "; between them belongs " + chain_text(survey, chain);
  const std::string taken = signal_name(gap.taken());
  const bool is_reversed = !shortest_chain(survey, {gap.taken()}, gap.given()).empty();
  return "; no controllers lead from " + given + " to " + taken +
         (is_reversed ? ", but some from " + taken + " to " + given + ": is the order right?" : "");
}

}  // namespace

std::string scenario_file(const std::string& scenario) {
  std::error_code ignored;
  if (!std::filesystem::exists(scenario, ignored) ||
      std::filesystem::is_directory(scenario, ignored)) {
    if (const auto shipped = find_shipped_scenario(scenario)) return shipped->string();
  }
  return scenario;
}

bool check_plugin_path(const LoadOptions& options, Diagnostics& diagnostics) {
  const int errors_before = diagnostics.error_count();
  check_folders(options.plugin_path, "the plugin path", diagnostics);
  check_folders(environment_search_path(), "SKYBODY_PLUGIN_PATH", diagnostics);
  return diagnostics.error_count() == errors_before;
}

std::shared_ptr<PluginRegistry> find_plugins(const LoadOptions& options) {
  std::vector<std::filesystem::path> path = options.plugin_path;
  if (options.trust_scenario) {
    for (auto& place : folders_beside(options)) path.push_back(std::move(place));
  }
  for (auto& place : default_search_path()) path.push_back(std::move(place));
  return std::make_shared<PluginRegistry>(path, options.refused_plugins);
}

std::string plugin_hint(const std::string& name) {
  return plugin_hint(name, RegistryCatalog(find_plugins({})));
}

std::unique_ptr<PluginCatalog> make_catalog(std::shared_ptr<const PluginRegistry> registry) {
  return std::make_unique<RegistryCatalog>(std::move(registry));
}

std::shared_ptr<const CompiledScenario> compile_scenario(const LoadOptions& options,
                                                         Diagnostics& diagnostics) {
  if (!check_scenario_name(options.scenario, diagnostics)) return nullptr;
  if (!check_plugin_path(options, diagnostics)) return nullptr;
  return compile_scenario(options, find_plugins(options), diagnostics);
}

std::shared_ptr<const CompiledScenario> compile_scenario(
    const LoadOptions& options, const std::shared_ptr<const PluginRegistry>& registry,
    Diagnostics& diagnostics) {
  const FpEnvironment guard;
  ScenarioEdit edit;
  if (!options.reference.empty()) {
    // First compile the scenario without the reference: only then are the controllers' inputs
    // known.
    LoadOptions plain = options;
    plain.reference.clear();
    Diagnostics found;
    const auto compiled = compile_scenario(plain, registry, found);
    if (compiled) edit = reference_edit(options.reference, *compiled, diagnostics);
    if (!compiled) diagnostics.add(found);
    if (!edit) return nullptr;
  }
  const RegistryCatalog catalog(registry, bystanders(options, *registry));
  std::optional<Scenario> scenario =
      read_scenario(scenario_file(options.scenario), options.overrides, catalog, diagnostics, edit);
  if (!scenario || diagnostics.has_errors()) return nullptr;
  const SourceLocation whole{scenario->file, 0, 0};
  try {
    fit_couplings(*scenario);
    take_trajectory_of_task(*scenario);
    RegistryFactory factory(*registry, options);
    auto compiled = std::make_shared<const CompiledScenario>(
        std::move(*scenario), factory, options.checked ? Checking::kYes : Checking::kNo);
    check_plugin_combinations(*compiled);
    check_world(compiled->world());  // reports worlds that cannot be built
    warn_of_implausible_parameters(*compiled, diagnostics);
    return compiled;
  } catch (const ChainMismatchError& gap) {
    diagnostics.error(gap.mark(), gap.message() + bridge(gap, *registry));
  } catch (const LocatedError& e) {
    diagnostics.error(e.mark(), e.message());
  } catch (const Error& e) {
    diagnostics.error(whole, e.what());
  }
  return nullptr;
}

std::shared_ptr<const CompiledScenario> compile_scenario(const LoadOptions& options) {
  Diagnostics diagnostics;
  auto compiled = compile_scenario(options, diagnostics);
  diagnostics.throw_if_errors();
  return compiled;
}

}  // namespace skybody
