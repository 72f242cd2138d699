// Trains rl_tools' published tiny SAC on its own quadrotor (L2F) to hover, and measures its policy
// as in our table of learning speed: the distance from the target over an episode's last second,
// and the number of episodes that end before.
//
//     rl_tools_hover SEED POINTS      prints POINTS lines of JSON, one for each share of the
//     training
//
// Built by research/learning/rl_tools.py against the user's checkout. Algorithm, networks,
// vehicle, initial states, reward and termination are those of the checkout's
// src/rl/zoo/l2f/sac_tiny.h. Two differences: the target does not move (the zoo's flies a figure of
// eight), in training and in evaluation; and the clock stops while a policy is evaluated.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

// Each of these needs those above it.
// clang-format off
#include <rl_tools/operations/cpu_mux.h>
#include <rl_tools/nn/optimizers/adam/instance/operations_generic.h>
#include <rl_tools/nn/operations_cpu_mux.h>
#include <rl_tools/nn/layers/sample_and_squash/operations_generic.h>
#include <rl_tools/nn/layers/standardize/operations_generic.h>
#include <rl_tools/nn_models/mlp/operations_generic.h>
#include <rl_tools/nn_models/random_uniform/operations_generic.h>
#include <rl_tools/nn_models/sequential/operations_generic.h>
#include <rl_tools/nn/optimizers/adam/operations_generic.h>
#include <rl_tools/containers/tensor/persist_code.h>
#include <rl_tools/nn/layers/dense/persist_code.h>
#include "l2f/sac_tiny.h"
#include <rl_tools/rl/algorithms/sac/loop/core/operations_generic.h>
#include <rl_tools/rl/utils/evaluation/operations_cpu.h>
// clang-format on

namespace rlt = RL_TOOLS_NAMESPACE_WRAPPER ::rl_tools;

namespace {

using Device = rlt::devices::DEVICE_FACTORY<>;
using Index = Device::index_t;
using Random = Device::SPEC::RANDOM::ENGINE<>;
using Types = rlt::numeric_types::Policy<
    float, rlt::numeric_types::UseCase<rlt::numeric_types::categories::Parameter, float>>;
using Config =
    rlt::rl::zoo::l2f::sac::FACTORY<Device, Types, Index, Random, true>::LOOP_CORE_CONFIG;
using Loop = Config::State<Config>;
using Environment = Config::ENVIRONMENT;
using Clock = std::chrono::steady_clock;

constexpr Index kEpisodes = 100;
constexpr Index kLength = 350;  // steps of 20 ms: the 7 s of hover_learn
constexpr Index kSecond = 50;   // steps
constexpr Index kHeldOutSeed = 1000;

using Flights =
    rlt::rl::utils::evaluation::Specification<Types, Index, Environment, kEpisodes, kLength>;

/// All objects of a run and its evaluations.
struct Training {
  Device device;
  Loop loop;
  rlt::rl::utils::evaluation::Result<Flights> result;
  rlt::rl::utils::evaluation::Data<rlt::rl::utils::evaluation::DataSpecification<Flights>> flights;
};

template <class Parameters>
void stay(Parameters& parameters) {
  auto& path = parameters.trajectory_parameters.parameters.lissajous;
  path.A = path.B = path.C = 0.0F;
}

void begin(Training& training, Index seed) {
  rlt::malloc(training.device);
  rlt::init(training.device);
  rlt::malloc(training.device, training.loop);
  rlt::malloc(training.device, training.flights);
  rlt::init(training.device, training.loop, seed);
  for (Index k = 0; k < Config::CORE_PARAMETERS::N_ENVIRONMENTS; ++k) {
    stay(rlt::get(training.loop.off_policy_runner.envs, 0, k).parameters);
  }
}

/// Mean distance from the target over the last second of the episode [m].
float error_of(Training& training, Index episode) {
  const Index length = training.result.episode_length[episode];
  const Index first = length > kSecond ? length - kSecond : 0;
  double sum = 0.0;
  for (Index step = first; step < length; ++step) {
    const auto& x = rlt::get_ref(training.device, training.flights.states, episode, step).position;
    sum += std::sqrt(static_cast<double>(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]));
  }
  return static_cast<float>(sum / static_cast<double>(length - first));
}

/// Flies the held-out episodes with the mean of the policy's distribution, and prints the results.
void evaluate(Training& training, double seconds) {
  Environment environment;
  rlt::init(training.device, environment);
  stay(environment.parameters);
  Random random;
  rlt::malloc(training.device, random);
  rlt::init(training.device, random, kHeldOutSeed);
  rlt::rl::environments::DummyUI nobody;
  const rlt::Mode<rlt::mode::Evaluation<>> mean;
  rlt::evaluate(training.device, environment, nobody, rlt::get_actor(training.loop),
                training.result, training.flights, random, mean);
  rlt::free(training.device, random);
  std::printf(
      "{\"steps\": %llu, \"seconds\": %.6f, \"errors\": [",
      static_cast<unsigned long long>(training.loop.step * Config::CORE_PARAMETERS::N_ENVIRONMENTS),
      seconds);
  for (Index k = 0; k < kEpisodes; ++k) {
    std::printf("%s%.6g", k > 0 ? ", " : "", static_cast<double>(error_of(training, k)));
  }
  std::printf("], \"failures\": %llu}\n",
              static_cast<unsigned long long>(training.result.num_terminated));
  std::fflush(stdout);
}

void train(Training& training, Index points) {
  constexpr Index kSteps = Config::CORE_PARAMETERS::STEP_LIMIT;
  double seconds = 0.0;
  for (Index point = 1; point <= points; ++point) {
    const Clock::time_point begun = Clock::now();
    while (training.loop.step < kSteps * point / points) rlt::step(training.device, training.loop);
    seconds += std::chrono::duration<double>(Clock::now() - begun).count();
    evaluate(training, seconds);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const long seed = argc > 1 ? std::atol(argv[1]) : 1;
  const long points = argc > 2 ? std::atol(argv[2]) : 10;
  if (argc > 3 || seed < 0 || points < 1) {
    std::fprintf(stderr, "rl_tools_hover SEED POINTS: SEED at least 0, POINTS at least 1\n");
    return 2;
  }
  static Training training;
  begin(training, static_cast<Index>(seed));
  train(training, static_cast<Index>(points));
  return 0;
}
