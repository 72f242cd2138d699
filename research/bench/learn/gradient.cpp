// Learning curve of `gradient`: trains, and every few updates flies held-out episodes with the
// policy at the scenario's own physics steps. Each evaluation prints one line. Training: seconds of
// the process without evaluations, cost, norm of the gradient, error and faults. Held-out episodes:
// the median error over the last second, the worst tenth's, failures and the mean return.
//
//   bench_gradient [SCENARIO] [NAME=VALUE ...]
//
// Names are those of the hyper-parameters (docs/training.md), and seed, updates, threads, every,
// held_out (a seed).
#include <chrono>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <string>

#include "core/assemble/compile_scenario.h"
#include "core/base/system/error.h"
#include "core/io/files/text.h"
#include "learn/hyperparameter_text.h"
#include "learn/make_learner.h"
#include "research/bench/learn/held_out.h"

namespace {

using namespace skybody;
using Clock = std::chrono::steady_clock;

struct Options {
  LoadOptions load;
  learn::Hyperparameters hyper;
  std::int64_t seed = 1, updates = 100, threads = 2, every = 20, held_out = 777;

  Options() { load.scenario = "hover_learn"; }

  std::int64_t* own(const std::string& name) {
    if (name == "seed") return &seed;
    if (name == "updates") return &updates;
    if (name == "threads") return &threads;
    if (name == "every") return &every;
    return name == "held_out" ? &held_out : nullptr;
  }

  void take(const std::string& argument) {
    const std::size_t at = argument.find('=');
    if (at == std::string::npos) {
      load.scenario = argument;
      return;
    }
    std::int64_t* const to = own(argument.substr(0, at));
    if (to == nullptr) {
      learn::set(hyper, learn::Algorithm::kGradient, argument);
      return;
    }
    const std::optional<double> value = parse_number(argument.substr(at + 1));
    if (!value || !(*value >= 1.0 && *value <= 1e9) ||
        *value != static_cast<double>(static_cast<std::int64_t>(*value))) {
      throw Error("`" + argument + "`: allowed is a whole number from 1 to 1e9");
    }
    *to = static_cast<std::int64_t>(*value);
  }
};

std::unique_ptr<learn::Learner> make_learner(
    const Options& options, const std::shared_ptr<const CompiledScenario>& compiled) {
  learn::LearnerOptions made;
  made.compiled = compiled;
  made.hyper = options.hyper;
  made.seed = static_cast<std::uint64_t>(options.seed);
  made.threads = static_cast<int>(options.threads);
  made.total_steps = options.updates * options.hyper.envs * options.hyper.rollout_steps;
  return learn::make_learner(learn::Algorithm::kGradient, options.load, made);
}

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

void print(std::int64_t update, double seconds, const learn::Report& report,
           const bench::HeldOut& held_out) {
  std::printf("update %4lld steps %8lld  %.3f s of process ", static_cast<long long>(update),
              static_cast<long long>(report.steps), seconds);
  for (const auto& [name, value] : report.losses) std::printf(" %s %.4g", name.c_str(), value);
  std::printf(
      " error %.2f m faults %lld | median %.4f m p90 %.4f m failures %d of %d return %.1f\n",
      report.position_error, static_cast<long long>(report.faults), held_out.median,
      held_out.worst_tenth, held_out.failures, bench::kHeldOut, held_out.mean_return);
  std::fflush(stdout);
}

void run(const Options& options) {
  const Clock::time_point start = Clock::now();
  const auto compiled = compile_scenario(options.load);
  const auto learner = make_learner(options, compiled);
  std::printf("ready after %.3f s\n", seconds_since(start));
  double looked = 0.0;
  for (std::int64_t update = 1; update <= options.updates; ++update) {
    const learn::Report report = learner->iterate();
    if (update % options.every != 0 && update != options.updates) continue;
    const double seconds = seconds_since(start) - looked;
    const Clock::time_point look = Clock::now();
    print(update, seconds, report,
          bench::fly_held_out(compiled, learner->policy(),
                              static_cast<std::uint64_t>(options.held_out)));
    looked += seconds_since(look);
  }
  std::printf("hash %016llx\n", static_cast<unsigned long long>(learner->parameter_hash()));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Options options;
    for (int i = 1; i < argc; ++i) options.take(argv[i]);
    run(options);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_gradient: error: %s\n", error.what());
    return 2;
  }
}
