// skybody run: flies a scenario, writes the log, the picture and a table.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/arguments.h"
#include "app/commands/command.h"
#include "app/flight.h"
#include "app/interrupt.h"
#include "app/onnx_policy.h"
#include "app/report/drawn_values.h"
#include "app/report/flight_record.h"
#include "app/report/output.h"
#include "app/report/output_folder.h"
#include "app/report/picture.h"
#include "app/report/reported_values.h"
#include "app/report/summary.h"
#include "app/scenario_options.h"
#include "core/base/system/error.h"
#include "core/io/files/text.h"
#include "core/policy/policy.h"

namespace skybody {
namespace {

constexpr double kDefaultSeconds = 10.0;
constexpr double kReferenceSeconds = 20.0;
constexpr std::uint64_t kMostEpisodes = 1000000;
constexpr std::uint64_t kMostSteps = 1000000000000;

constexpr const char* kRunFooter =
    "Policies:\n"
    "- zero: the middle of every command's range\n"
    "- random: uniform in that range, a function of seed, episode and step\n"
    "- hold: hovers at the task's goal\n"
    "- shipped: the trained policy that Skybody has for this scenario\n"
    "- PATH: a policy.h5, a folder with a policy.h5, or a training run's folder, of which the\n"
    "  newest checkpoint is used; or a policy.onnx, with --map FILE if its inputs have other "
    "names\n"
    "  than the observations (docs/export_policy.md)\n"
    "Files: DIR/flight.h5 and DIR/flight-0001.png, -0002, -0003 of the first three episodes.\n"
    "Without --out, DIR is a new folder: flights/SCENARIO-SEED, or if it exists, with -2, -3, ...\n"
    "at the end. With --out, an existing log and pictures are replaced at the end of the flight.\n"
    "References: circle, helix, lissajous, figure_eight, waypoints, csv, step, hold and those of\n"
    "the paper. The controller `reference`, and controllers between it and the robot's chain, are\n"
    "put before that chain; the task `watch` replaces the scenario's task (docs/references.md).\n"
    "Ctrl-C ends the flight after the current step; the log is kept, exit status 130. A second\n"
    "Ctrl-C ends the program at once, without the log.\n"
    "Examples:\n"
    "  skybody run hover\n"
    "  skybody run payload --episodes 3 --seed 7 --out /tmp/payload\n"
    "  skybody run hover --policy random --set stepping.horizon=500 --no-picture\n"
    "  skybody run hover_learn --policy runs/first --episodes 5\n"
    "  skybody run formation_learn --policy shipped --episodes 5\n"
    "  skybody run hover --reference figure_eight:peak_speed=3,yaw=tangent";

struct RunOptions {
  LoadOptions load;
  RolloutPlan plan;
  std::uint64_t seed = 0;
  std::string policy = "hold";
  std::filesystem::path map;  ///< of a policy in ONNX
  std::filesystem::path out;
  bool no_picture = false;
  bool view = false;
};

/// Accepts a baseline's name, or a file or folder that exists.
CLI::Validator policy_argument() {
  const auto check = [](const std::string& text) -> std::string {
    std::vector<std::string> names = policy_names();
    names.emplace_back(kShippedPolicy);
    std::error_code ignored;
    if (std::count(names.begin(), names.end(), text) > 0) return "";
    if (std::filesystem::exists(text, ignored)) return "";
    const std::string near = closest(text, names);
    return "there is no policy or file `" + text + "`" + plugin_hint(text) +
           (near.empty() ? "" : "; did you mean `" + near + "`?") + "; allowed: " + join(names) +
           ", a policy.h5, a policy.onnx, or a folder with checkpoints";
  };
  return {check, "", "policy"};
}

/// Step limit of an episode: the option if given, otherwise the horizon, otherwise ten seconds, or
/// twenty along a reference, because of its approach and ramp.
std::uint64_t most_steps(const RunOptions& options, const Stepping& stepping) {
  if (options.plan.most_steps > 0) return options.plan.most_steps;
  if (stepping.horizon > 0) return static_cast<std::uint64_t>(stepping.horizon);
  const double seconds = options.load.reference.empty() ? kDefaultSeconds : kReferenceSeconds;
  const double steps = std::ceil(seconds / (stepping.dt * stepping.action_repeat));
  return static_cast<std::uint64_t>(std::fmax(1.0, steps));
}

std::unique_ptr<Policy> open_policy(const RunOptions& options, const CompiledScenario& compiled) {
  if (is_onnx(options.policy)) return open_onnx_policy(options.policy, options.load, options.map);
  if (!options.map.empty()) throw Error("--map is for a --policy in ONNX");
  return make_policy(options.policy, compiled, options.seed);
}

/// Flies and leaves the finished log in `folder`, also after a signal (InterruptGuard::signal).
std::vector<EpisodeSummary> fly_and_log(const RunOptions& options, const RolloutPlan& plan,
                                        const std::shared_ptr<const CompiledScenario>& compiled,
                                        Policy& policy, OutputFolder& folder) {
  Simulation simulation(compiled, options.seed, 0);
  const InterruptGuard guard;
  FlightLog log(folder.partial_log(), describe_flight(*compiled, options.seed, options.policy));
  std::vector<EpisodeSummary> episodes = fly(plan, simulation, policy, log);
  log.close();
  folder.commit();
  return episodes;
}

void print_summary(const CompiledScenario& compiled, const std::vector<EpisodeSummary>& episodes) {
  print(summary_table(compiled, episodes));
  std::vector<std::vector<ReferenceError>> references;
  for (const EpisodeSummary& episode : episodes) references.push_back(episode.references);
  const std::string followed = reference_table(compiled, references);
  if (!followed.empty()) std::printf("\n%s", followed.c_str());
  const std::string drawn = drawn_values(compiled, episodes);
  if (!drawn.empty()) std::printf("\n%s", drawn.c_str());
  const std::string reported = reported_values(compiled, episodes);
  if (!reported.empty()) std::printf("\n%s", reported.c_str());
  std::uint64_t redraws = 0;
  for (const EpisodeSummary& episode : episodes) redraws += episode.redraws;
  if (redraws > 0) std::printf("starts drawn again: %s\n", std::to_string(redraws).c_str());
}

/// Prints a line for each file, or a warning.
void print_made(const char* word, const MadeFiles& made) {
  for (const std::filesystem::path& file : made.files) std::printf("%-8s %s\n", word, file.c_str());
  std::fflush(stdout);
  if (!made.failure.empty()) spdlog::warn("no {}: {}", word, made.failure);
}

int run(const RunOptions& options) {
  skip_hdf5_cleanup_at_exit();
  const auto compiled = load_and_warn(options.load);
  const auto policy = open_policy(options, *compiled);
  const std::string warning = policy->check_fits(*compiled);
  if (!warning.empty()) spdlog::warn(warning);
  RolloutPlan plan = options.plan;
  plan.most_steps = most_steps(options, compiled->scenario().stepping);
  OutputFolder folder(options.out, compiled->scenario().name, options.seed);
  const std::vector<EpisodeSummary> episodes =
      fly_and_log(options, plan, compiled, *policy, folder);
  print_summary(*compiled, episodes);
  std::printf("\nlog      %s\n", folder.log().c_str());
  std::fflush(stdout);
  if (InterruptGuard::signal() != 0) {
    std::printf("draw it  skybody plot %s\n", folder.log().c_str());
    std::fflush(stdout);
    spdlog::warn("interrupted in episode {} of {}; what was flown is in the log",
                 std::max<std::size_t>(1, episodes.size()), plan.episodes);
    return kExitSignal + InterruptGuard::signal();
  }
  if (!options.no_picture) print_made("picture", draw_pictures(folder.log()));
  if (options.view) print_made("page", write_view(folder.log()));
  return kExitDone;
}

}  // namespace

void add_run_command(CLI::App& app, Action& chosen) {
  CLI::App* command =
      app.add_subcommand("run", "Fly a scenario; write a log, a picture and a table");
  const auto options = std::make_shared<RunOptions>();
  command->footer(kRunFooter);
  add_scenario_options(*command, options->load);
  add_checked(*command, options->load);
  add_reference(*command, options->load);
  command->add_option("--episodes", options->plan.episodes, "Episodes to fly (1)")
      ->type_name("N")
      ->check(whole_number(1, kMostEpisodes));
  command
      ->add_option("--steps", options->plan.most_steps,
                   "Largest number of steps per episode (the horizon; without one 10 s, with a "
                   "reference 20 s)")
      ->type_name("N")
      ->check(whole_number(1, kMostSteps));
  command->add_option("--seed", options->seed, "Key of all random numbers (0)")
      ->type_name("S")
      ->check(whole_number(0, UINT64_MAX));
  command
      ->add_option(
          "--policy", options->policy,
          "zero, random, hold, shipped, or a trained policy: policy.h5, a checkpoint, a training "
          "run, or policy.onnx (hold)")
      ->type_name("NAME|PATH")
      ->check(policy_argument())
      ->excludes("--reference");
  command->add_option("--map", options->map, "Observations that are the inputs of a policy.onnx")
      ->type_name("FILE")
      ->check(CLI::ExistingFile.description(""));
  command->add_option("--out", options->out, "Folder for the log and the pictures")
      ->type_name("DIR");
  command->add_flag("--no-picture", options->no_picture, "Draw no pictures");
  command->add_flag("--view", options->view,
                    "Also write a page that plays the flight in a browser");
  command->callback([options, &chosen] { chosen = [options] { return run(*options); }; });
}

}  // namespace skybody
