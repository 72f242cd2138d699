#include "tests/fuzz/options.h"

#include <CLI/CLI.hpp>

#include "app/arguments.h"
#include "app/report/machine.h"
#include "tests/fuzz/area.h"

namespace skybody::fuzz {
namespace {

constexpr const char* kFooter =
    "Input K of an area follows from seed, area and K alone. Exit status: 0 nothing found, 1\n"
    "something found, 2 wrong use.\n"
    "Examples:\n"
    "  skybody_fuzz --minutes 30 --save build/fuzz\n"
    "  skybody_fuzz --inputs 1000000\n"
    "  skybody_fuzz urdf rotors --seed 7 --count 10000\n"
    "  skybody_fuzz urdf --seed 7 --first 1234 --count 1 --here\n"
    "  skybody_fuzz urdf --input build/fuzz/urdf_7_1234";

std::vector<std::string> area_names() {
  std::vector<std::string> names;
  for (const AreaRow& row : area_rows()) names.emplace_back(row.name);
  return names;
}

void declare(CLI::App& app, Options& options) {
  app.footer(kFooter);
  app.add_option("AREA", options.areas, "Areas; all where none is named")
      ->check(CLI::IsMember(area_names()));
  app.add_option("--seed", options.seed, "Of all inputs (1)");
  app.add_option("--first", options.first, "Number of the first input (0)");
  CLI::Option* count = app.add_option("--count", options.count, "Inputs of each area")
                           ->check(whole_number(1, 1'000'000'000));
  app.add_option("--minutes", options.minutes, "Time for all areas together, shared equally")
      ->check(number_within(0.01, 100'000.0))
      ->excludes(count);
  app.add_option("--inputs", options.inputs,
                 "At least so many inputs of all areas together, beside the time if both are given")
      ->check(whole_number(1, 1'000'000'000'000))
      ->excludes(count);
  app.add_flag("--corpus", options.corpus, "First the valid inputs and the files of the corpus");
  app.add_option("--input", options.input, "Run this file; one area is to be named")
      ->check(CLI::ExistingFile);
  app.add_option("--save", options.save, "Folder for inputs with findings");
  app.add_option("--markdown", options.markdown, "File for the table");
  app.add_option("--policy", options.policy, "A valid policy.h5 to change")
      ->check(CLI::ExistingFile);
  app.add_option("--jobs", options.jobs, "Processes at a time (one per processor)")
      ->check(CLI::Range(1, 256));
  app.add_flag("--here", options.in_process, "Run in this process, for a debugger");
}

std::string joined(int count, char** arguments) {
  std::string command = "skybody_fuzz";
  for (int k = 1; k < count; ++k) command += std::string(" ") + arguments[k];
  return command;
}

}  // namespace

bool parse_options(int count, char** arguments, Options& options, int& status) {
  CLI::App app("Gives mutated inputs to Skybody and says which are answered wrongly",
               "skybody_fuzz");
  options.jobs = processor_count();
  declare(app, options);
  try {
    app.parse(count, arguments);
    if (!options.input.empty() && options.areas.size() != 1) {
      throw CLI::ValidationError("--input", "name the area that the file belongs to");
    }
    if (options.count == 0 && !options.shares_time() && !options.corpus && options.input.empty()) {
      throw CLI::ValidationError("nothing to run",
                                 "give --count, --minutes, --inputs, --corpus or --input");
    }
  } catch (const CLI::ParseError& error) {
    status = app.exit(error) == 0 ? 0 : 2;
    return false;
  }
  options.command = joined(count, arguments);
  return true;
}

}  // namespace skybody::fuzz
