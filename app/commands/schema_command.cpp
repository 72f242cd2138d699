// skybody schema: the JSON schema of scenario files, for editors, and their keys as tables.
#include <CLI/CLI.hpp>

#include "app/commands/command.h"
#include "app/plugin_child.h"
#include "app/report/output.h"
#include "app/scenario_options.h"
#include "core/io/yaml/scenario_fields.h"
#include "core/io/yaml/schema.h"

namespace skybody {
namespace {

constexpr const char* kSchemaFooter =
    "The schema contains all plugins on the search path. To use it in VS Code with the YAML\n"
    "extension, write into a scenario:\n"
    "  # yaml-language-server: $schema=scenario.schema.json\n"
    "Example:\n"
    "  skybody schema > scenario.schema.json\n"
    "  skybody schema --markdown               # tables of docs/scenarios.md";

int print_schema(LoadOptions options, const RefusedFiles& refused) {
  options.refused_plugins = refused;
  const auto catalog = make_catalog(open_plugins(options));
  const std::string schema = scenario_schema(*catalog);
  print(schema);
  if (schema.empty() || schema.back() != '\n') print("\n");
  return kExitDone;
}

int print_tables() {
  print(scenario_reference());
  return kExitDone;
}

}  // namespace

void add_schema_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("schema", "Print the JSON schema of scenario files");
  const auto options = std::make_shared<LoadOptions>();
  command->footer(kSchemaFooter);
  add_plugin_path(*command, *options);
  const auto markdown = std::make_shared<bool>(false);
  command->add_flag("--markdown", *markdown, "Print the keys as Markdown tables instead");
  command->callback([options, markdown, &chosen] {
    chosen = [options, markdown] {
      if (*markdown) return print_tables();
      return run_in_child(
          [&](const RefusedFiles& refused) { return print_schema(*options, refused); });
    };
  });
}

}  // namespace skybody
