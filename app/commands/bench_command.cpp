// skybody bench: measures the steps per second of a batch of environments on this machine.
#include <skybody/build_info.h>

#include <chrono>
#include <cstdio>
#include <ctime>

#include "app/arguments.h"
#include "app/batch_actions.h"
#include "app/commands/command.h"
#include "app/commands/physics_cost.h"
#include "app/interrupt.h"
#include "app/pool_options.h"
#include "app/report/machine.h"
#include "app/report/output.h"
#include "app/report/text_table.h"
#include "app/scenario_options.h"
#include "core/base/math/hash.h"
#include "core/io/files/json.h"
#include "core/io/files/text.h"
#include "core/version.h"

namespace skybody {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLongestWarmUp = 1.0;  // [s]

constexpr const char* kBenchFooter =
    "Counts environment steps without resets; each consists of K physics steps. Actions:\n"
    "- hold: the constant action of the hold policy after five seconds;\n"
    "- zero: the middle of every range;\n"
    "- random: uniform, drawn before the measurement.\n"
    "The share of physics is an estimate: the time of the physics steps, measured on one thread\n"
    "without other load, over the time of all threads. Batches contain no info values. No other\n"
    "program should run during the measurement.\n"
    "Examples:\n"
    "  skybody bench hover --envs 128\n"
    "  skybody bench payload --envs 96 --batch 32 --order arrival --threads 4 --seconds 10 --json";

struct BenchOptions {
  LoadOptions load;
  PoolOptions envs = {.envs = 64};
  std::string actions = "hold";
  double seconds = 5.0;
  bool json = false;
};

/// Counters, and the time of the measurement.
struct Counts {
  std::uint64_t steps = 0, resets = 0, faults = 0;
  double seconds = 0.0;
  double processor_seconds = 0.0;  ///< of all threads
};

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Waits for pending environments without stepping them again.
void drain(Pool& envs) {
  while (envs.in_flight() > 0) envs.recv();
}

/// Steps every environment again as soon as it returns, until the time is over.
Counts run_for(double seconds, Pool& envs, BatchActions& actions) {
  Counts counts;
  const std::uint64_t faults = envs.faults();
  const double computed = processor_seconds();
  const Clock::time_point begin = Clock::now();
  while (counts.seconds < seconds && InterruptGuard::signal() == 0) {
    const std::shared_ptr<const Batch> batch = envs.recv();
    const auto rows = static_cast<std::size_t>(batch->rows);
    std::uint64_t resets = 0;
    for (std::size_t k = 0; k < rows; ++k) resets += batch->was_reset[k];
    counts.resets += resets;
    counts.steps += rows - resets;
    if (rows == static_cast<std::size_t>(envs.envs())) {
      envs.send(actions.next(rows));
    } else {
      envs.send(actions.next(rows), std::span(batch->env_id).first(rows));
    }
    counts.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  }
  counts.processor_seconds = processor_seconds() - computed;
  counts.faults = envs.faults() - faults;
  return counts;
}

/// Results of the measurement.
struct Figures {
  double steps, steps_per_thread, physics_steps, physics_share;
  double near_share;  ///< fraction of the physics steps, including warm-up, with shapes close
                      ///< enough for contact
};

Figures figures_of(const Counts& counts, const Pool& envs, double physics_cost) {
  const double repeat = envs.compiled().scenario().stepping.action_repeat;
  const double steps = static_cast<double>(counts.steps) / counts.seconds;
  const StepCounts physics = envs.step_counts();
  return {steps, steps / envs.threads(), steps * repeat,
          steps * repeat * physics_cost / envs.threads(),
          static_cast<double>(physics.near) / static_cast<double>(physics.all)};
}

std::string count_text(double value) { return fixed(value, value < 1000.0 ? 1 : 0); }

void print_table(const BenchOptions& options, const Pool& envs, const Counts& counts,
                 const Figures& figures) {
  std::printf("%s: %d environments, batches of %d (%s), %d threads, actions %s, %s s\n%s (%s)\n\n",
              envs.compiled().scenario().name.c_str(), envs.envs(), envs.batch(),
              to_text(options.envs.order).c_str(), envs.threads(), options.actions.c_str(),
              fixed(counts.seconds, 1).c_str(), machine_name().c_str(), processor_name().c_str());
  TextTable table({"", "value"});
  table.add({"env steps/s", count_text(figures.steps)});
  table.add({"env steps/s per thread", count_text(figures.steps_per_thread)});
  table.add({"physics steps/s", count_text(figures.physics_steps)});
  table.add({"share of physics [%]", fixed(100.0 * figures.physics_share, 1)});
  table.add({"physics steps near contact [%]", fixed(100.0 * figures.near_share, 1)});
  table.add({"resets", std::to_string(counts.resets)});
  table.add({"faults", std::to_string(counts.faults)});
  print(table.to_string());
}

void print_json(const BenchOptions& options, const Pool& envs, const Counts& counts,
                const Figures& figures) {
  const Scenario& scenario = envs.compiled().scenario();
  JsonObject json;
  json.set_text("scenario", scenario.name)
      .set_text("scenario_hash", to_hex(scenario.hash))
      .set("envs", std::to_string(envs.envs()))
      .set("batch", std::to_string(envs.batch()))
      .set("threads", std::to_string(envs.threads()))
      .set_text("order", to_text(options.envs.order))
      .set_text("actions", options.actions)
      .set("action_repeat", std::to_string(scenario.stepping.action_repeat))
      .set("seconds", format_number(counts.seconds))
      .set("processor_seconds", format_number(counts.processor_seconds))
      .set("env_steps", std::to_string(counts.steps))
      .set("env_steps_per_second", format_number(figures.steps))
      .set("env_steps_per_second_per_thread", format_number(figures.steps_per_thread))
      .set("physics_steps_per_second", format_number(figures.physics_steps))
      .set("physics_share", format_number(figures.physics_share))
      .set("near_share", format_number(figures.near_share))
      .set("resets", std::to_string(counts.resets))
      .set("faults", std::to_string(counts.faults))
      .set_text("machine", machine_name())
      .set_text("processor", processor_name())
      .set("processors", std::to_string(processor_count()))
      .set_text("skybody_version", version())
      .set_text("build", SKYBODY_BUILD_TYPE)
      .set_text("simbody", SKYBODY_SIMBODY_VERSION)
      .set("simbody_asserts", SKYBODY_SIMBODY_NDEBUG != 0 ? "false" : "true");
  print(json_indented(json.text()) + "\n");
}

int bench(const BenchOptions& options) {
  const auto compiled = load_and_warn(options.load);
  PoolOptions how = options.envs;
  how.info = false;
  Pool envs(compiled, how);
  BatchActions actions(options.actions, compiled, envs.envs());
  const InterruptGuard guard;
  const double physics_cost = physics_step_cost(*compiled, envs.lanes());
  envs.send_reset();
  run_for(std::min(kLongestWarmUp, options.seconds), envs, actions);
  const Counts counts = run_for(options.seconds, envs, actions);
  if (InterruptGuard::signal() != 0) return kExitSignal + InterruptGuard::signal();
  drain(envs);
  const Figures figures = figures_of(counts, envs, physics_cost);
  (options.json ? print_json : print_table)(options, envs, counts, figures);
  return kExitDone;
}

}  // namespace

void add_bench_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("bench", "Measure the environment steps per second");
  const auto options = std::make_shared<BenchOptions>();
  command->footer(kBenchFooter);
  add_scenario_options(*command, options->load);
  add_pool_options(*command, options->envs);
  command
      ->add_option("--seconds", options->seconds,
                   "Duration of the measurement, after a warm-up (5)")
      ->type_name("S")
      ->check(number_within(0.05, 86400.0));
  command->add_option("--actions", options->actions, "hold, zero or random (hold)")
      ->type_name("WHICH")
      ->check(one_of("actions", BatchActions::names()));
  command->add_flag("--json", options->json, "Print JSON instead of a table");
  command->callback([options, &chosen] { chosen = [options] { return bench(*options); }; });
}

}  // namespace skybody
