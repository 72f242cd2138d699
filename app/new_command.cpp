// skybody new: writes a plugin project to start from.
#include <cstdio>

#include "app/arguments.h"
#include "app/command.h"
#include "core/base/plugin_kind.h"
#include "plugins/host/new_project.h"

namespace skybody {
namespace {

constexpr const char* kNewFooter =
    "Writes the folder DIR/NAME: a small plugin that works, its build file, a test, a scenario "
    "that\n"
    "flies it and a README with the commands.\n"
    "Example:\n"
    "  skybody new controller my_law && cat my_law/README.md";

struct NewOptions {
  std::string kind, name;
  std::filesystem::path folder = ".";
};

int write_project(const NewOptions& options) {
  const SkybodyKind kind = kind_from_name(options.kind).value();
  const std::filesystem::path written =
      write_new_plugin_project(kind, options.name, options.folder);
  std::printf("%s\nnext: read %s\n", written.c_str(), (written / "README.md").c_str());
  return kExitDone;
}

std::vector<std::string> kind_words() {
  std::vector<std::string> words;
  for (const PluginKindRow& kind : kPluginKinds) words.emplace_back(kind.word);
  return words;
}

}  // namespace

void add_new_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("new", "Write a plugin project to start from");
  const auto options = std::make_shared<NewOptions>();
  command->footer(kNewFooter);
  command->add_option("KIND", options->kind, kind_names())
      ->required()
      ->type_name("")
      ->check(one_of("kind of plugin", kind_words()));
  command->add_option("NAME", options->name, "Name of the plugin, in lower_snake_case")
      ->required()
      ->type_name("");
  command->add_option("--dir", options->folder, "Folder in which the project's folder is made (.)")
      ->type_name("DIR");
  command->callback([options, &chosen] { chosen = [options] { return write_project(*options); }; });
}

}  // namespace skybody
