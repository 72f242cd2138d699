// skybody replay: repeats a recording, or compares two, and reports the first difference.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "app/arguments.h"
#include "app/commands/command.h"
#include "app/report/output.h"
#include "app/scenario_options.h"
#include "core/base/system/printable.h"
#include "core/batch/pool_options.h"
#include "core/io/files/flight_log.h"
#include "core/replay/replay_player.h"
#include "core/version.h"

namespace skybody {
namespace {

constexpr const char* kReplayFooter =
    "FILE is written by `skybody hash --record FILE`, or from Python by `envs.record(FILE)`. It\n"
    "contains the inputs of the environments and a hash after each transition. The command\n"
    "repeats the run on any number of threads and compares every hash. With --against, it\n"
    "compares two recordings and runs nothing. Exit status: 0 identical, 1 the runs differ, 2 an\n"
    "error.\n"
    "Examples:\n"
    "  skybody hash hover --envs 8 --steps 500 --record run.h5 --states\n"
    "  skybody replay run.h5 --threads 4\n"
    "  skybody replay run.h5 --against other.h5";

struct ReplayOptions {
  std::filesystem::path file, against;
  std::string scenario;
  LoadOptions load;  ///< only the search path of plugins
  int threads = 0;
};

int conclude(const ReplayReport& report, const ReplayHeader& header, const std::string& first,
             const std::string& second) {
  print(report.text(header, first, second));
  return report.identical() ? kExitDone : kExitDiffers;
}

void warn_of_version(const ReplayReader& replay) {
  const std::string& recorded = replay.header().skybody_version;
  if (recorded == version()) return;
  spdlog::warn("{} was recorded by Skybody {}; this is {}: results may differ",
               replay.file().string(), printable(recorded), version());
}

/// Warns of recorded folders that are missing on the command line.
void warn_of_plugin_path(const ReplayOptions& options, const ReplayReader& replay) {
  const std::vector<std::filesystem::path>& given = options.load.plugin_path;
  for (const std::string& folder : replay.header().plugin_path) {
    const auto same = [&folder](const std::filesystem::path& other) {
      std::error_code ignored;
      return std::filesystem::equivalent(folder, other, ignored);
    };
    if (std::any_of(given.begin(), given.end(), same)) continue;
    spdlog::warn(
        "{} was recorded with plugins from `{}`, which is not searched; if you trust this folder, "
        "give it with --plugin-path",
        replay.file().string(), printable(folder));
  }
}

/// Plugins are searched for in the command line's folders, not in those of the recording.
LoadOptions load_options(const ReplayOptions& options, const ReplayHeader& header) {
  LoadOptions load = replay_load_options(header);
  if (!options.scenario.empty()) load.scenario = options.scenario;
  load.plugin_path = options.load.plugin_path;
  load.trust_scenario = options.load.trust_scenario;
  return load;
}

int replay(const ReplayOptions& options) {
  skip_hdf5_cleanup_at_exit();
  ReplayReader recording(options.file);
  if (!options.against.empty()) {
    const ReplayReader other(options.against);
    return conclude(compare_replays(recording, other), recording.header(), options.file.string(),
                    options.against.string());
  }
  warn_of_version(recording);
  warn_of_plugin_path(options, recording);
  const auto compiled = load_and_warn(load_options(options, recording.header()));
  return conclude(play(recording, compiled, options.threads), recording.header(), "recorded",
                  "replayed");
}

}  // namespace

void add_replay_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("replay", "Repeat a recording and compare the results");
  const auto options = std::make_shared<ReplayOptions>();
  command->footer(kReplayFooter);
  command->add_option("FILE", options->file, "A recording")->required()->type_name("");
  CLI::Option* against =
      command->add_option("--against", options->against, "Another recording to compare with")
          ->type_name("FILE2");
  command->add_option("--threads", options->threads, "Number of threads; 0: one per processor (0)")
      ->type_name("T")
      ->check(whole_number(0, kMostThreads))
      ->excludes(against);
  command
      ->add_option("--scenario", options->scenario,
                   "Current path of the scenario, if it has moved since the recording")
      ->type_name("FILE")
      ->excludes(against);
  add_plugin_path(*command, options->load);
  add_trust_scenario(*command, options->load);
  command->callback([options, &chosen] { chosen = [options] { return replay(*options); }; });
}

}  // namespace skybody
