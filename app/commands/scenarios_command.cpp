// skybody scenarios: lists the shipped scenarios.
#include <CLI/CLI.hpp>
#include <algorithm>

#include "app/commands/command.h"
#include "app/report/output.h"
#include "app/report/text_table.h"
#include "core/base/system/printable.h"
#include "core/io/files/file.h"
#include "core/io/files/shipped_files.h"
#include "core/io/yaml/include_chain.h"

namespace skybody {
namespace {

constexpr const char* kScenariosFooter =
    "The column `policy` states whether Skybody has a trained policy for the scenario\n"
    "(`skybody run NAME --policy shipped`), `presets` whether it has hyper-parameters for\n"
    "`skybody train NAME`.\n"
    "Example:\n"
    "  skybody scenarios";

constexpr std::size_t kLongestAbout = 100;  // [bytes]

/// The comment at the start of a file, up to its first full stop, colon or semicolon.
std::string about(const std::string& file) {
  Diagnostics ignored;
  const std::string text = read_file(file, {}, ignored).value_or("");
  std::string comment;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line) && line.rfind('#', 0) == 0;) {
    comment += line.substr(1);
  }
  std::size_t end = comment.size();
  for (const char* stop : {". ", ": ", "; "}) end = std::min(end, comment.find(stop));
  while (end > 0 && comment[end - 1] == '.') --end;
  const std::size_t begin = std::min(comment.find_first_not_of(' '), end);
  return shortened(printable(comment.substr(begin, end - begin)), kLongestAbout);
}

int list_scenarios() {
  TextTable table({"scenario", "policy", "presets", "about"});
  for (const std::string& name : shipped_scenarios()) {
    const std::string file = find_shipped_scenario(name).value().string();
    table.add({name, find_shipped_policy(name) ? "yes" : "",
               is_file(training_presets(file)) ? "yes" : "", about(file)});
  }
  print(table.to_string());
  return kExitDone;
}

}  // namespace

void add_scenarios_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("scenarios", "List the shipped scenarios");
  command->footer(kScenariosFooter);
  command->callback([&chosen] { chosen = list_scenarios; });
}

}  // namespace skybody
