// One environment under direct control: the class to link into lab code.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/assemble/load.h"
#include "core/env/environment.h"
#include "core/physics/lane_state.h"

namespace skybody {

/// How a Simulation is made.
struct SimulationOptions {
  std::string scenario;                     ///< YAML file, or the name of a shipped scenario
  std::vector<std::string> overrides = {};  ///< "PATH=VALUE", as for --set
  std::uint64_t seed = 0;                   ///< key of all random numbers
  std::uint64_t env_id = 0;                 ///< second half of the key: equal ids, equal draws
  std::vector<std::filesystem::path> plugin_path = {};  ///< searched before the default places
};

/// The whole WorldState of one environment. Only for environments of the same scenario.
struct Snapshot {
  std::uint64_t scenario_hash = 0;
  std::vector<std::uint64_t> words;
  std::vector<float> observation;  ///< the last transition's row
  float reward = 0.0f;
  HashChain trajectory;  ///< over all transitions so far
  bool started = false;  ///< an episode has begun
};

/// Loads a scenario and steps it. Not thread-safe; several Simulations are independent.
class Simulation {
 public:
  /// @throws InputError with every message, each with file:line:column
  explicit Simulation(const SimulationOptions& options);
  /// Shares an already loaded environment.
  Simulation(std::shared_ptr<const Environment> environment, std::uint64_t seed,
             std::uint64_t env_id);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Begins the next episode.
  void reset();
  /// Begins episode 1 under another seed; drawn values return to nominal first.
  void reset(std::uint64_t seed);

  /// One transition: K physics steps with `action`, values in [-1, 1] (clipped). A non-finite
  /// action or state ends the episode as a fault.
  /// @throws Error if the size is not action_size(), or if no reset() came before
  void step(std::span<const float> action);

  std::span<const float> observation() const;  ///< after the last reset or step
  float reward() const;
  std::span<const float> agent_rewards() const;  ///< one per agent; the team's where it has no own
  std::span<const float> info() const;           ///< the task's info values, as declared
  bool terminated() const;                       ///< the task ended the episode
  bool truncated() const;                        ///< horizon, or a fault
  bool fault() const;
  std::uint64_t status() const;  ///< EpisodeStatus bits, with the reason of a fault
  bool done() const { return terminated() || truncated(); }

  int action_size() const;
  int observation_size() const;
  std::uint64_t episode() const;        ///< 1 in the first
  std::uint64_t steps() const;          ///< actions taken in this episode
  std::uint64_t physics_steps() const;  ///< physics steps taken in this episode
  double time() const;                  ///< since the reset [s]

  const Environment& environment() const { return *environment_; }
  const Scenario& scenario() const { return environment_->scenario(); }

  /// Motion of the body that a link belongs to. Robot "" is the only one.
  /// @throws Error naming the robots or links that exist
  const BodyState& body(const std::string& robot, const std::string& link) const;
  const std::vector<BodyState>& bodies() const;  ///< all, in the world's numbering
  std::vector<double> rotor_speeds() const;      ///< [rad/s], the world's numbering
  std::vector<double> rotor_commands() const;    ///< [rad/s], held during the last physics step
  std::vector<double> commands() const;          ///< of each robot's first controller
  std::vector<double> actions() const;           ///< last action, clipped
  std::vector<double> sensors() const;           ///< outputs of all sensors
  std::vector<double> params() const;            ///< EnvParams; names in environment().layout()
  /// Where the task wants its goals: 4 values each, position (W) [m], yaw [rad].
  std::vector<double> goals() const;

  /// Value of a randomizable parameter. @throws Error if there is none at `path`
  double param(const std::string& path) const;
  /// Sets one. @throws Error if unknown or outside its bounds
  void set_param(const std::string& path, double value);
  /// Draws from all randomizers now, in mid-episode; motion goes on.
  void randomize();

  /// Everything: motion, rotors, drawn values, plugin states, counters, random key.
  Snapshot save() const;
  /// @throws Error if the snapshot is of another scenario
  void restore(const Snapshot& snapshot);
  /// A copy with the same future; with `rekey` its random numbers are its own.
  Simulation fork(bool rekey = false);

  /// Hash over all transitions since construction (or the restored snapshot): state words,
  /// observation, reward, flags.
  std::uint64_t hash() const;
  /// Whether transitions are added to the hash (default: yes). It costs about as much as a light
  /// transition.
  void keep_hash(bool keep);

 private:
  void touch() const;
  void add_to_hash();
  std::shared_ptr<const Environment> environment_;
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace skybody
