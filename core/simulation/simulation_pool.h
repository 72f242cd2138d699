// Many worlds under direct control, on the threads of a Crew. For learning at speed there is VecEnv
// (core/batch), which steps worlds side by side in lanes; this pool is for work that its caller
// writes, world by world.
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
  int worlds = 1;                  ///< N >= 1
  std::uint64_t seed = 0;          ///< world i draws with the key (seed, first_env_id + i)
  std::uint64_t first_env_id = 0;  ///< see seed
  bool pin_threads = false;        ///< workers each on a processor of their own, where allowed
  int threads = 0;  ///< the caller counted; 0: one per processor, at most one per world
};

/// N worlds of one scenario. run() and what steps or resets share the worlds that they name out
/// among the threads, of which the caller is one, wait for all of them, and only then throw what
/// the first of them (by number) threw; world() and what only reads or writes states work on the
/// caller's. What a world does depends on its key and its own calls alone. Not thread-safe: one
/// caller at a time.
class SimulationPool {
 public:
  /// What a call does in one world, on any of the threads. A thread may have several worlds to do,
  /// one after another: work in one world must not wait for work in another.
  using Work = std::function<void(Simulation& world, int index)>;

  /// @throws Error if an option is out of range, or if the system gives fewer threads
  SimulationPool(std::shared_ptr<const Environment> environment,
                 const SimulationPoolOptions& options);
  ~SimulationPool();
  SimulationPool(const SimulationPool&) = delete;
  SimulationPool& operator=(const SimulationPool&) = delete;

  int size() const { return static_cast<int>(all_.size()); }
  /// Threads that step, the caller counted; after close() as before.
  int threads() const { return threads_; }
  /// Workers that have a processor of their own; 0 where the system does not allow it.
  int pinned_threads() const { return pinned_; }
  const Environment& environment() const { return *environment_; }
  /// The numbers of all worlds, 0 .. size() - 1: for the calls below.
  std::span<const int> all() const { return all_; }
  /// One world, between calls. @throws Error if there is none of that number, or after close()
  Simulation& world(int index);

  /// Does `work` in some worlds at the same time.
  /// @param worlds  numbers, each at most once
  /// @throws Error if a number is out of range or twice there (then nothing was done), after
  ///         close(), or with "world 3: " before the message of what its work threw
  void run(std::span<const int> worlds, const Work& work);

  /// Begins the next episode of some worlds. @throws Error as run()
  void reset(std::span<const int> worlds);
  /// Begins episode 1 of some worlds under another seed. @throws Error as run()
  void reset(std::span<const int> worlds, std::uint64_t seed);
  /// One transition of each. @param actions  a row of action_size() for each of `worlds`, in [-1,
  /// 1]
  /// @throws Error as run(), or on another number of values
  void step(std::span<const int> worlds, std::span<const float> actions);
  /// Sets commands in physical units, see Simulation::command().
  /// @param values  a row for each of `worlds`
  /// @throws Error as run(), or on another number of values
  void command(std::span<const int> worlds, const std::string& robot,
               std::span<const double> values);
  /// Physics steps of each under its commands. A world whose physics gives up ends its episode as a
  /// fault (Simulation::fault()), which is no error. @throws Error as run(), or if steps < 0
  void advance(std::span<const int> worlds, std::int64_t physics_steps);
  /// Ends a transition made by command() and advance(). @throws Error as run()
  void evaluate(std::span<const int> worlds);

  /// A value of the state of every world, on the caller's thread: see Environment::state_values().
  /// @param values  size() x StateValue::count(), written
  /// @throws Error if there is no such value, on another number of values, or after close()
  void state(std::string_view path, std::span<double> values);

  /// Ends the threads and destroys the worlds. May be called again.
  void close();
  bool closed() const { return worlds_ == nullptr; }

 private:
  class Worlds;
  void check_open() const;
  void check(std::span<const int> worlds) const;

  std::shared_ptr<const Environment> environment_;
  std::vector<int> all_;
  std::vector<std::size_t> rows_;  ///< of each world, by its number, during a step
  std::unique_ptr<Worlds> worlds_;
  int threads_ = 0, pinned_ = 0;
};

}  // namespace skybody
