// skybody plugins: what was found on the search path.
#include <cstdio>

#include "app/command.h"
#include "app/output.h"
#include "app/parameter_table.h"
#include "app/scenario_options.h"
#include "app/text_table.h"
#include "core/base/error.h"
#include "core/io/text.h"
#include "plugins/host/kind.h"
#include "plugins/host/registry.h"

namespace skybody {
namespace {

constexpr const char* kFooter =
    "Looks in --plugin-path, SKYBODY_PLUGIN_PATH and the folder of shipped plugins. `lanes` says\n"
    "whether a plugin serves several environments at a time. Files that cannot be used are listed\n"
    "below the table, with the reason.\n"
    "Examples:\n"
    "  skybody plugins --verbose\n"
    "  skybody plugins --markdown controller/rotor_speed";

struct PluginsOptions {
  LoadOptions load;
  bool verbose = false;
  std::string markdown;  ///< KIND/NAME
};

std::string count_of(const PluginEntry& entry) { return std::to_string(entry.parameters.size()); }

void print_usable(const PluginRegistry& registry) {
  TextTable table({"name", "kind", "version", "lanes", "parameters", "file"});
  for (const PluginEntry& entry : registry.entries()) {
    if (!entry.failure.empty()) continue;
    table.add({entry.name, std::string(kind_name(entry.kind)), entry.version,
               entry.vectorized ? "yes" : "no", count_of(entry), entry.file.string()});
  }
  if (!table.empty()) print(table.to_string());
}

void print_details(const PluginRegistry& registry) {
  for (const PluginEntry& entry : registry.entries()) {
    if (!entry.failure.empty()) continue;
    std::printf("\n%s %s %s: %s\n", std::string(kind_name(entry.kind)).c_str(), entry.name.c_str(),
                entry.version.c_str(), entry.doc.c_str());
    if (!entry.parameters.empty()) print(parameter_lines(entry.parameters));
  }
}

void print_failures(const PluginRegistry& registry) {
  bool first = true;
  for (const PluginEntry& entry : registry.entries()) {
    if (entry.failure.empty()) continue;
    if (first) std::printf("\ncannot be used:\n");
    first = false;
    std::printf("  %s: %s\n", entry.file.c_str(), entry.failure.c_str());
  }
}

void print_places(const PluginRegistry& registry) {
  std::vector<std::string> places;
  for (const std::filesystem::path& place : registry.search_path())
    places.push_back(place.string());
  std::printf("\nsearched: %s\n", join(places).c_str());
}

/// KIND/NAME -> the entry. @throws Error with what there is
const PluginEntry& require_plugin(const PluginRegistry& registry,
                                  const std::string& kind_and_name) {
  std::vector<std::string> known;
  for (const PluginEntry& entry : registry.entries()) {
    if (!entry.failure.empty()) continue;
    known.push_back(std::string(kind_name(entry.kind)) + "/" + entry.name);
    if (known.back() == kind_and_name) return entry;
  }
  throw Error("--markdown: there is no plugin `" + kind_and_name + "`" +
              suggestion(kind_and_name, known, "there are"));
}

int list_plugins(const PluginsOptions& options) {
  const std::shared_ptr<const PluginRegistry> registry = find_plugins(options.load);
  if (!options.markdown.empty()) {
    const PluginEntry& entry = require_plugin(*registry, options.markdown);
    print(parameter_markdown(entry.parameters));
    return kExitDone;
  }
  print_usable(*registry);
  if (options.verbose) print_details(*registry);
  print_failures(*registry);
  print_places(*registry);
  return kExitDone;
}

}  // namespace

void add_plugins_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("plugins", "List all plugins that are found");
  const auto options = std::make_shared<PluginsOptions>();
  command->footer(kFooter);
  add_plugin_path(*command, options->load);
  command->add_flag("--verbose", options->verbose, "With every parameter of every plugin");
  command->add_option("--markdown", options->markdown, "Print one plugin's parameters in Markdown")
      ->type_name("KIND/NAME");
  command->callback([options, &chosen] { chosen = [options] { return list_plugins(*options); }; });
}

}  // namespace skybody
