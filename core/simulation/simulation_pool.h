// Many environments under direct control, on the threads of a ThreadPool. For learning at speed
// there is Pool (core/batch), which steps environments side by side in lanes; this pool is for work
// that its caller writes, environment by environment.
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

/// How a SimulationPool is made.
struct SimulationPoolOptions {
  int envs = 1;                    ///< N >= 1
  std::uint64_t seed = 0;          ///< environment i draws with the key (seed, first_env_id + i)
  std::uint64_t first_env_id = 0;  ///< see seed
  bool pin_threads = false;        ///< workers each on a processor of their own, where allowed
  int threads = 0;  ///< the caller counted; 0: one per processor, at most one per environment
};

/// N environments of one scenario. run() and what steps or resets share the environments that they
/// name out among the threads, of which the caller is one, wait for all of them, and only then
/// throw what the first of them (by number) threw; simulation() and what only reads or writes
/// states work on the caller's. What an environment does depends on its key and its own calls
/// alone. Not thread-safe: one caller at a time.
class SimulationPool {
 public:
  /// What a call does in one environment, on any of the threads. A thread may have several
  /// environments to do, one after another: work in one environment must not wait for work in
  /// another.
  using Work = std::function<void(Simulation& sim, int index)>;

  /// @throws Error if an option is out of range, or if the system gives fewer threads
  SimulationPool(std::shared_ptr<const CompiledScenario> compiled,
                 const SimulationPoolOptions& options);
  ~SimulationPool();
  SimulationPool(const SimulationPool&) = delete;
  SimulationPool& operator=(const SimulationPool&) = delete;

  int size() const { return static_cast<int>(all_.size()); }
  /// Threads that step, the caller counted; after close() as before.
  int threads() const { return threads_; }
  /// Workers that have a processor of their own; 0 where the system does not allow it.
  int pinned_threads() const { return pinned_; }
  const CompiledScenario& compiled() const { return *compiled_; }
  /// The numbers of all environments, 0 .. size() - 1: for the calls below.
  std::span<const int> all() const { return all_; }
  /// One environment, between calls. @throws Error if there is none of that number, or after
  /// close()
  Simulation& simulation(int index);

  /// Does `work` in some environments at the same time.
  /// @param envs  numbers, each at most once
  /// @throws Error if a number is out of range or twice there (then nothing was done), after
  ///         close(), or with "environment 3: " before the message of what its work threw
  void run(std::span<const int> envs, const Work& work);

  /// Begins the next episode of some environments. @throws Error as run()
  void reset(std::span<const int> envs);
  /// Begins episode 1 of some environments under another seed. @throws Error as run()
  void reset(std::span<const int> envs, std::uint64_t seed);
  /// One transition of each. @param actions  a row of action_size() for each of `envs`, in [-1,
  /// 1]
  /// @throws Error as run(), or on another number of values
  void step(std::span<const int> envs, std::span<const float> actions);
  /// Sets commands in physical units, see Simulation::command().
  /// @param values  a row for each of `envs`
  /// @throws Error as run(), or on another number of values
  void command(std::span<const int> envs, const std::string& robot, std::span<const double> values);
  /// Physics steps of each under its commands. An environment whose physics gives up ends its
  /// episode as a fault (Simulation::fault()), which is no error. @throws Error as run(), or if
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
  std::vector<std::size_t> rows_;  ///< of each environment, by its number, during a step
  std::unique_ptr<Simulations> simulations_;
  int threads_ = 0, pinned_ = 0;
};

}  // namespace skybody
