// skybody plugins: lists the plugins on the search path.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <set>

#include "app/commands/command.h"
#include "app/plugin_child.h"
#include "app/report/output.h"
#include "app/report/parameter_table.h"
#include "app/report/text_table.h"
#include "app/scenario_options.h"
#include "core/base/plugin_kind.h"
#include "core/base/system/error.h"
#include "core/io/files/text.h"
#include "core/plugin_host/registry.h"

namespace skybody {
namespace {

constexpr const char* kPluginsFooter =
    "Searches --plugin-path, SKYBODY_PLUGIN_PATH and the folder of shipped plugins. The column\n"
    "`lanes` states whether a plugin computes several environments at a time. Files that cannot\n"
    "be used are listed below the table, with the reason.\n"
    "Examples:\n"
    "  skybody plugins --verbose\n"
    "  skybody plugins --markdown controller/rotor_speed";

struct PluginsOptions {
  LoadOptions load;
  bool verbose = false;
  std::string markdown;  ///< KIND/NAME
};

using Entries = std::vector<const PluginEntry*>;

std::string count_of(const PluginEntry& entry) { return std::to_string(entry.parameters.size()); }

void print_usable(const Entries& entries) {
  TextTable table({"name", "kind", "version", "lanes", "parameters", "file"});
  for (const PluginEntry* entry : entries) {
    if (!entry->failure.empty()) continue;
    table.add({entry->name, std::string(kind_name(entry->kind)), entry->version,
               entry->vectorized ? "yes" : "no", count_of(*entry), entry->file.string()});
  }
  if (!table.empty()) print(table.to_string());
}

void print_details(const Entries& entries) {
  for (const PluginEntry* entry : entries) {
    if (!entry->failure.empty()) continue;
    std::printf("\n%s %s %s: %s\n", kind_name(entry->kind), entry->name.c_str(),
                entry->version.c_str(), entry->doc.c_str());
    if (!entry->parameters.empty()) print(parameter_lines(entry->parameters));
  }
}

void print_failures(const Entries& entries) {
  std::set<std::string> said;  // a file that promises several plugins fails for each of them
  for (const PluginEntry* entry : entries) {
    if (entry->failure.empty() || !said.insert(entry->failure).second) continue;
    if (said.size() == 1) std::printf("\ncannot be used:\n");
    std::printf("  %s\n", entry->failure.c_str());
  }
}

void print_places(const PluginRegistry& registry) {
  std::vector<std::string> places;
  for (const std::filesystem::path& place : registry.search_path())
    places.push_back(place.string());
  std::printf("\nsearched: %s\n", join(places).c_str());
}

/// The entry of KIND/NAME. @throws Error with the available ones
const PluginEntry& require_plugin(const Entries& entries, const std::string& kind_and_name) {
  std::vector<std::string> known;
  for (const PluginEntry* entry : entries) {
    if (!entry->failure.empty()) continue;
    known.push_back(std::string(kind_name(entry->kind)) + "/" + entry->name);
    if (known.back() == kind_and_name) return *entry;
  }
  throw Error("--markdown: there is no plugin `" + kind_and_name + "`" +
              suggestion(kind_and_name, known, "there are"));
}

int list_plugins(PluginsOptions options, const RefusedFiles& refused) {
  options.load.refused_plugins = refused;
  const std::shared_ptr<const PluginRegistry> registry = open_plugins(options.load);
  const Entries entries = registry->open_all();
  if (!options.markdown.empty()) {
    const PluginEntry& entry = require_plugin(entries, options.markdown);
    print(parameter_markdown(entry.parameters));
    return kExitDone;
  }
  print_usable(entries);
  if (options.verbose) print_details(entries);
  print_failures(entries);
  print_places(*registry);
  return kExitDone;
}

}  // namespace

void add_plugins_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("plugins", "List all plugins on the search path");
  const auto options = std::make_shared<PluginsOptions>();
  command->footer(kPluginsFooter);
  add_plugin_path(*command, options->load);
  command->add_flag("--verbose", options->verbose, "Also list the parameters of every plugin");
  command->add_option("--markdown", options->markdown, "Print one plugin's parameters in Markdown")
      ->type_name("KIND/NAME");
  command->callback([options, &chosen] {
    chosen = [options] {
      return run_in_child(
          [&](const RefusedFiles& refused) { return list_plugins(*options, refused); });
    };
  });
}

}  // namespace skybody
