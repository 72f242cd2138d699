// skybody hash: one line that says whether two machines, builds or runs fly the same trajectory.
#include <cstdio>
#include <vector>

#include "app/arguments.h"
#include "app/command.h"
#include "app/scenario_options.h"
#include "core/assemble/simulation.h"
#include "core/base/error.h"
#include "core/base/random.h"

namespace skybody {
namespace {

constexpr std::uint64_t kMost = 1000000000000;

constexpr const char* kFooter =
    "Each environment takes a reset and then exactly K steps; where an episode has ended, the "
    "next\n"
    "step is a reset. Its hash is a chain over all state words, observation, reward and status "
    "after\n"
    "each of them. The actions of step k of environment e are uniform in [-1, 1], drawn from "
    "Philox\n"
    "with key (seed, e), step k, stream `hash.action`. The chains are combined in the order of "
    "the\n"
    "environments.\n"
    "Example:\n"
    "  skybody hash scenarios/hover.yaml --envs 1 --threads 1 --batch 1 --steps 20000 --seed 7";

struct HashOptions {
  LoadOptions load;
  std::uint64_t envs = 1, threads = 1, batch = 1, steps = 1000, seed = 0;
  std::string order = "fixed";
};

void require_one(const char* option, std::uint64_t value) {
  if (value == 1) return;
  throw Error(std::string(option) + " is " + std::to_string(value) +
              "; allowed: 1, for the batch engine does not exist yet");
}

std::uint64_t hash_environment(const std::shared_ptr<const Environment>& environment,
                               const HashOptions& options, std::uint64_t env) {
  Simulation simulation(environment, options.seed, env);
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  simulation.reset();
  for (std::uint64_t k = 0; k < options.steps; ++k) {
    if (simulation.done()) {
      simulation.reset();
      continue;
    }
    Random<double> random(RandomKey{options.seed, env}, 0, k, derive_stream("hash.action"));
    for (float& value : action) value = static_cast<float>(random.uniform(-1.0, 1.0));
    simulation.step(action);
  }
  return simulation.hash();
}

int hash(const HashOptions& options) {
  require_one("--envs", options.envs);
  require_one("--threads", options.threads);
  require_one("--batch", options.batch);
  const auto environment = load_and_warn(options.load);
  HashChain all;
  for (std::uint64_t env = 0; env < options.envs; ++env) {
    all.update(hash_environment(environment, options, env));
  }
  std::printf("%s\n", to_hex(all.value()).c_str());
  return kExitDone;
}

void add_count(CLI::App& command, const char* name, std::uint64_t& value, const char* letter,
               const char* doc) {
  command.add_option(name, value, doc)->type_name(letter)->check(whole_number(1, kMost));
}

}  // namespace

void add_hash_command(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("hash", "Print a hash over all states of a flight");
  const auto options = std::make_shared<HashOptions>();
  command->footer(kFooter);
  add_scenario_options(*command, options->load);
  add_count(*command, "--envs", options->envs, "N", "Environments (1)");
  add_count(*command, "--threads", options->threads, "T", "Threads (1)");
  add_count(*command, "--batch", options->batch, "B", "Environments a batch (1)");
  add_count(*command, "--steps", options->steps, "K", "Steps of each environment (1000)");
  command->add_option("--order", options->order, "fixed or arrival (fixed)")
      ->type_name("ORDER")
      ->check(one_of("order", {"fixed", "arrival"}));
  command->add_option("--seed", options->seed, "Key of all random numbers (0)")
      ->type_name("S")
      ->check(whole_number(0, UINT64_MAX));
  command->callback([options, &chosen] { chosen = [options] { return hash(*options); }; });
}

}  // namespace skybody
