// Many environments under direct control, on the threads of a ThreadPool. For fast learning use
// Pool (core/batch), which steps environments side by side in lanes. This pool runs the caller's
// own functions, environment by environment.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/simulation/simulation.h"

namespace skybody {

/// Options of a SimulationPool.
struct SimulationPoolOptions {
  int envs = 1;                    ///< N >= 1
  std::uint64_t seed = 0;          ///< environment i draws with the key (seed, first_env_id + i)
  std::uint64_t first_env_id = 0;  ///< see seed
  bool pin_threads = false;        ///< each worker on a processor of its own, where allowed
  int threads = 0;  ///< including the caller; 0: one per processor, at most one per environment
};

/// N environments of one scenario. run() and the methods that step or reset distribute the given
/// environments among the threads, including the caller's, and wait for all of them. Only then they
/// rethrow the exception of the environment with the lowest number. simulation() and the methods
/// that only read or write states work on the caller's thread. The behaviour of an environment
/// depends only on its key and its own calls. Not thread-safe: one caller at a time.
class SimulationPool {
 public:
  /// Work in one environment, on any of the threads. A thread may process several environments one
  /// after another, so work in one environment must not wait for work in another.
  using Work = std::function<void(Simulation& sim, int index)>;

  /// @throws Error if an option is out of range, or if the system provides fewer threads
  SimulationPool(std::shared_ptr<const CompiledScenario> compiled,
                 const SimulationPoolOptions& options);
  ~SimulationPool();
  SimulationPool(const SimulationPool&) = delete;
  SimulationPool& operator=(const SimulationPool&) = delete;

  int size() const { return static_cast<int>(all_.size()); }
  /// Threads that step, including the caller; unchanged after close().
  int threads() const { return threads_; }
  /// Workers that have a processor of their own; 0 where the system does not allow it.
  int pinned_threads() const { return pinned_; }
  const CompiledScenario& compiled() const { return *compiled_; }
  /// The numbers of all environments, 0 .. size() - 1: for the calls below.
  std::span<const int> all() const { return all_; }
  /// One environment, between calls. @throws Error if there is none of that number, or after
  /// close()
  Simulation& simulation(int index);

  /// Runs `work` in some environments in parallel.
  /// @param envs  numbers, each at most once
  /// @throws Error if a number is out of range or listed twice (then nothing was done), after
  ///   close(), or with "environment 3: " before the message of an exception from `work`
  void run(std::span<const int> envs, const Work& work);

  /// Begins the next episode of some environments. @throws Error as run()
  void reset(std::span<const int> envs);
  /// Begins episode 1 of some environments with another seed. @throws Error as run()
  void reset(std::span<const int> envs, std::uint64_t seed);
  /// One transition of each.
  /// @param actions  a row of action_size() for each of `envs`, in [-1, 1]
  /// @throws Error as run(), or on another number of values
  void step(std::span<const int> envs, std::span<const float> actions);
  /// Sets commands in physical units, see Simulation::command().
  /// @param values  a row for each of `envs`
  /// @throws Error as run(), or on another number of values
  void command(std::span<const int> envs, const std::string& robot, std::span<const double> values);
  /// Physics steps of each under its commands. If the physics of an environment fails, its episode
  /// ends as a fault (Simulation::fault()), without an exception. @throws Error as run(), or if
  /// steps < 0
  void advance(std::span<const int> envs, std::int64_t physics_steps);
  /// Ends a transition made by command() and advance(). @throws Error as run()
  void evaluate(std::span<const int> envs);

  /// A value of the state of every environment, on the caller's thread: see
  /// CompiledScenario::state_values().
  /// @param values  size() x StateValue::count(), written
  /// @throws Error if there is no such value, on another number of values, or after close()
  void state(std::string_view path, std::span<double> values);

  /// Ends the threads and destroys the environments. May be called again.
  void close();
  bool closed() const { return simulations_ == nullptr; }

 private:
  class Simulations;
  void check_open() const;
  void check(std::span<const int> envs) const;

  std::shared_ptr<const CompiledScenario> compiled_;
  std::vector<int> all_;
  std::vector<std::size_t> rows_;  ///< row of each environment, by its number, during a step
  std::unique_ptr<Simulations> simulations_;
  int threads_ = 0, pinned_ = 0;
};

}  // namespace skybody
