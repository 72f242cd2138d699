// skybody new: writes a starter project for a plugin, a vehicle or a laboratory.
#include <cstdio>

#include "app/arguments.h"
#include "app/commands/command.h"
#include "app/commands/new_lab.h"
#include "app/commands/new_vehicle.h"
#include "core/base/plugin_kind.h"
#include "core/plugin_host/new_project.h"

namespace skybody {
namespace {

constexpr const char* kNewFooter =
    "Writes the folder DIR/NAME: a small working plugin, its build file, a test, a scenario that\n"
    "uses it and a README with the commands. `skybody new vehicle` writes a vehicle, and\n"
    "`skybody new lab` a repository with a vehicle, a controller, a task, training and tests.\n"
    "Examples:\n"
    "  skybody new controller my_law && cat my_law/README.md\n"
    "  skybody new vehicle --mass 0.45 --arm 0.11 --thrust-to-weight 6";

constexpr const char* kVehicleFooter =
    "Writes the folder DIR/NAME: a URDF, rotors.yaml, a scenario that flies the vehicle and a\n"
    "README. All other properties follow from the scaling laws of the randomizer `vehicle`.\n"
    "Example:\n"
    "  skybody new vehicle my_hexa --mass 1.2 --arm 0.3 --thrust-to-weight 3 --rotors 6";

constexpr const char* kLabFooter =
    "Writes the folder DIR/NAME: the vehicle NAME_quad, the controller NAME_law and the task\n"
    "NAME_task, each as `skybody new` writes it, a scenario with all three, a preset for "
    "training,\n"
    "tests, a workflow for hosted tests and a README. It can be pushed as it is.\n"
    "Example:\n"
    "  skybody new lab my_lab && cat my_lab/README.md";

constexpr const char* kVehicle = "vehicle";
constexpr const char* kLab = "lab";

struct NewOptions {
  std::string kind, name;
  std::filesystem::path folder = ".";
};

void say_next(const std::filesystem::path& written) {
  std::printf("%s\nnext: read %s\n", written.c_str(), (written / "README.md").c_str());
}

int write_project(const NewOptions& options) {
  const SkybodyKind kind = kind_from_name(options.kind).value();
  say_next(write_new_plugin_project(kind, options.name, options.folder));
  return kExitDone;
}

int write_vehicle(const VehicleOptions& options) {
  std::fputs(doubts_of_vehicle(options).to_string().c_str(), stderr);
  say_next(write_new_vehicle(options));
  return kExitDone;
}

std::vector<std::string> kind_words() {
  std::vector<std::string> words;
  for (const PluginKindRow& kind : kPluginKinds) words.emplace_back(kind.word);
  return words;
}

void add_folder(CLI::App& command, std::filesystem::path& folder) {
  command.add_option("--dir", folder, "Parent of the new folder (.)")->type_name("DIR");
}

void add_new_vehicle_command(CLI::App& parent, Action& chosen) {
  CLI::App* command = parent.add_subcommand(kVehicle, "Write a starter vehicle");
  const auto options = std::make_shared<VehicleOptions>();
  command->footer(kVehicleFooter);
  command->add_option("NAME", options->name, "Name of the vehicle (vehicle)")->type_name("");
  const auto add_number = [&](const char* name, double& value, const char* doc, double least,
                              double greatest, const char* unit) {
    command->add_option(name, value, doc)
        ->required()
        ->type_name("")
        ->check(number_within(least, greatest, unit));
  };
  add_number("--mass", options->mass, "Mass [kg]", 1e-3, 1e3, "kg");
  add_number("--arm", options->arm, "Distance from the centre to a hub [m]", 1e-3, 10.0, "m");
  add_number("--thrust-to-weight", options->thrust_to_weight,
             "Thrust of all rotors at their largest speed, over the weight", 1.05, 20.0, "");
  command->add_option("--rotors", options->rotors, "Number of rotors, even (4)")
      ->type_name("")
      ->check(whole_number(4, 16));
  command
      ->add_option("--layout", options->layout,
                   "x: the x axis is between two arms; plus: one arm is on it")
      ->type_name("")
      ->check(one_of("layout", {"x", "plus"}));
  add_folder(*command, options->folder);
  command->callback([options, &chosen] { chosen = [options] { return write_vehicle(*options); }; });
}

void add_new_lab_command(CLI::App& parent, Action& chosen) {
  CLI::App* command = parent.add_subcommand(kLab, "Write the repository of a laboratory");
  const auto options = std::make_shared<NewOptions>();
  command->footer(kLabFooter);
  command->add_option("NAME", options->name, "Name of the repository, in lower_snake_case")
      ->required()
      ->type_name("");
  add_folder(*command, options->folder);
  command->callback([options, &chosen] {
    chosen = [options] {
      say_next(write_new_lab(options->name, options->folder));
      return kExitDone;
    };
  });
}

}  // namespace

void add_new_command(CLI::App& app, Action& chosen) {
  CLI::App* command =
      app.add_subcommand("new", "Write a starter project: a plugin, a vehicle or a lab");
  const auto options = std::make_shared<NewOptions>();
  command->footer(kNewFooter);
  command->add_option("KIND", options->kind, kind_names())
      ->type_name("")
      ->check(one_of("kind", kind_words(), {kVehicle, kLab}));
  command->add_option("NAME", options->name, "Name of the plugin, in lower_snake_case")
      ->type_name("");
  add_folder(*command, options->folder);
  add_new_vehicle_command(*command, chosen);
  add_new_lab_command(*command, chosen);
  command->callback([command, options, &chosen] {
    if (!command->get_subcommands().empty()) return;
    // Not declared as required, since that would also apply to the sub-commands.
    if (options->kind.empty()) throw CLI::RequiredError("KIND");
    if (options->name.empty()) throw CLI::RequiredError("NAME");
    chosen = [options] { return write_project(*options); };
  });
}

}  // namespace skybody
