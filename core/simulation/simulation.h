// One environment under direct control: the class for use in other programs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/env/compiled_scenario.h"
#include "core/env/param_request.h"
#include "core/env/state_values.h"
#include "core/physics/bodies/body_accelerations.h"
#include "core/physics/contact/contact.h"
#include "core/physics/world/lane_state.h"

namespace skybody {

/// Options of a Simulation.
struct SimulationOptions {
  std::string scenario;                     ///< YAML file, or the name of a shipped scenario
  std::vector<std::string> overrides = {};  ///< "PATH=VALUE", as for --set
  std::uint64_t seed = 0;                   ///< key of all random numbers
  std::uint64_t env_id = 0;                 ///< second half of the key: equal ids, equal draws
  std::vector<std::filesystem::path> plugin_path = {};  ///< searched before the default places
};

/// Accelerations at one instant.
struct Accelerations {
  std::vector<double> udot;              ///< generalised, one per u of the world's layout
  std::vector<BodyAcceleration> bodies;  ///< of all body frames, in the world's numbering
};

/// All state words of one environment. Only for environments of the same scenario.
struct Snapshot {
  std::uint64_t scenario_hash = 0;
  std::vector<std::uint64_t> words;
  std::vector<float> observation;  ///< row of the last transition; so are the next members
  std::vector<float> agent_rewards;
  std::vector<float> info;
  std::vector<float> privileged;
  float reward = 0.0f;
  HashChain trajectory;  ///< over all transitions so far
  bool started = false;  ///< an episode has begun
};

/// Loads a scenario and steps it: by step(), as a learner does, or under direct control by
/// command(), advance() and evaluate(). Frames: W world (z up), B body. Not thread-safe; several
/// Simulations are independent.
class Simulation {
 public:
  /// @throws InputError with all messages, each with file:line:column
  explicit Simulation(const SimulationOptions& options);
  /// Shares a compiled scenario.
  Simulation(std::shared_ptr<const CompiledScenario> compiled, std::uint64_t seed,
             std::uint64_t env_id);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Begins the next episode.
  void reset();
  /// Begins episode 1 with another seed; drawn values return to nominal first.
  void reset(std::uint64_t seed);

  /// One transition: K physics steps with `action`, values in [-1, 1] (clipped). A non-finite
  /// action or state ends the episode as a fault.
  /// @throws Error if the size is not action_size(), or before the first reset()
  void step(std::span<const float> action);

  /// Sets the command of a robot's chains of controllers, in their signals' units
  /// (docs/control-modes.md). It is held until the next command(), step() or reset(); a reset sets
  /// zeros. Controllers limit it to the robot's abilities.
  /// @param robot  "": the only robot; likewise below
  /// @throws Error before reset(), on an unknown robot or one without controllers, on another
  ///   number of values, or if one is not finite
  void command(const std::string& robot, std::span<const double> values);
  /// Number of values of that input. @throws Error as command()
  int command_size(const std::string& robot) const;

  /// Exactly `physics_steps` physics steps under the commands, sensors included; no task.
  /// @returns false if the physics failed: the environment is then in its last finite state, the
  ///   episode has ended as a fault, and nothing moves until a reset
  /// @throws Error before reset(), or if physics_steps < 0
  bool advance(std::int64_t physics_steps);

  /// Ends a transition made by command() and advance(), as step() ends its own: counts one step
  /// towards the horizon and evaluates the task for observation, reward and end.
  /// @throws Error before reset()
  void evaluate();

  /// Sets the state of a robot's floating base at the present time. Joints, rotors, other robots
  /// and sensors' last outputs remain, so bodies on joints move with the base. Overlaps with other
  /// bodies or the ground are not prevented.
  /// @param base  position and velocity in W [m, m/s], rotation W from B (any norm but 0), angular
  ///   velocity in B [rad/s]
  /// @throws Error before reset(), on an unknown robot, a fixed base or a value that is not finite
  void teleport(const std::string& robot, const BodyState& base);

  std::span<const float> observation() const;  ///< after the last reset or step
  std::span<const float> privileged() const;   ///< likewise: additional values for a critic
  /// One of the observation's images (CompiledScenario::images), as its sensor last made it.
  /// @throws Error if there is no such image
  std::span<const std::uint8_t> image(int image) const;
  float reward() const;
  std::span<const float> agent_rewards() const;  ///< one per agent; the team's reward if the task
                                                 ///< gives none per agent
  /// Info values: the task's, then other plugins' reports (CompiledScenario::info_channels).
  std::span<const float> info() const;
  bool terminated() const;  ///< the task ended the episode
  bool truncated() const;   ///< by horizon, task or fault
  bool fault() const;
  std::uint64_t status() const;  ///< EpisodeStatus bits, with the reason of a fault
  bool done() const { return terminated() || truncated(); }

  int action_size() const;
  int observation_size() const;
  std::uint64_t episode() const;        ///< 1 in the first
  std::uint64_t steps() const;          ///< actions taken in this episode
  std::uint64_t physics_steps() const;  ///< physics steps taken in this episode
  double time() const;                  ///< since the reset [s]
  /// Physics steps since construction, and the number of those with anything near a body. Not part
  /// of the state.
  const StepCounts& step_counts() const;

  const CompiledScenario& compiled() const { return *compiled_; }
  const Scenario& scenario() const { return compiled_->scenario(); }

  /// Motion of the body that a link belongs to. Robot "": the only robot.
  /// @throws Error with the names of the existing robots or links
  const BodyState& body(const std::string& robot, const std::string& link) const;
  /// Motion of a robot's base. @throws Error with the names of the existing robots
  const BodyState& base(const std::string& robot) const;
  const std::vector<BodyState>& bodies() const;  ///< all, in the world's numbering
  std::vector<double> rotor_speeds() const;      ///< [rad/s], the world's numbering
  std::vector<double> rotor_commands() const;    ///< [rad/s], held during the last physics step
  /// Inputs of all chains of controllers, in the order of compiled().chains().
  std::vector<double> commands() const;
  std::vector<double> actions() const;  ///< last action, clipped
  /// Outputs of all sensors but images, in the order of the scenario's `sensors`.
  std::vector<double> sensors() const;
  std::vector<double> params() const;  ///< EnvParams; names in compiled().layout()
  /// Accelerations now, for the rotors' present speeds and the rotor commands and wrenches of the
  /// last physics step. Driven bases have none.
  /// @throws Error if the dynamics fails
  Accelerations accelerations() const;
  /// Present contacts with the ground, obstacles or other robots.
  /// @throws Error if the dynamics fails
  std::vector<Contact> contacts() const;
  /// The task's goals: 4 values each, position (W) [m], yaw [rad].
  std::vector<double> goals() const;
  /// The goals' motion: 6 values each, velocity (W) [m/s], acceleration (W) [m/s^2]; 0 if the task
  /// does not provide it.
  std::vector<double> goal_motions() const;

  /// A value of the state, such as robots.quad.base.position: see CompiledScenario::state_values().
  /// @throws Error with the nearest paths if there is none at `path`
  std::vector<double> state(std::string_view path) const;
  /// As state(path), into the caller's memory.
  /// @param values  value.count() values, written. @throws Error on another number
  void state(const StateValue& value, std::span<double> values) const;

  /// Value of a randomizable parameter. @throws Error if there is none at `path`
  double param(const std::string& path) const;
  /// Sets a randomizable parameter. @throws Error if unknown or outside its bounds
  void set_param(const std::string& path, double value);
  /// Mass [kg], centre of mass [m] and inertia about it [kg m^2], in the frame of the body that a
  /// link belongs to: links on fixed joints are one body. @throws Error as body()
  MassProperties mass_properties(const std::string& robot, const std::string& link) const;
  /// Sets the mass properties during an episode; controllers continue with the nominal ones.
  /// @throws Error as body(), or if no rigid body can have them
  void set_mass_properties(const std::string& robot, const std::string& link,
                           const MassProperties& mass);
  /// A constant of one rotor, numbered in the order of the rotors file: thrust_constant, max_speed,
  /// tau_up and so on; units as in that file. @throws Error if there is no such rotor or constant
  double rotor_parameter(const std::string& robot, int rotor, const std::string& name) const;
  /// Sets a constant of one rotor. @throws Error likewise, or outside its bounds
  void set_rotor_parameter(const std::string& robot, int rotor, const std::string& name,
                           double value);
  /// Draws from all randomizers now, during an episode; motion continues.
  void randomize();
  /// Requests values of randomizable parameters, as Pool::request() does for one environment.
  /// @param when  kNextStep: before the next step() or advance(), or in the next reset(), whichever
  ///   comes first; kNextReset: in the next reset()
  /// @throws Error as ParamRequest
  void request(std::span<const ParamChange> changes, RequestTime when);

  /// The full state: motion, rotors, drawn values, plugin states, counters, random key.
  Snapshot save() const;
  /// @throws Error if the snapshot is of another scenario
  void restore(const Snapshot& snapshot);
  /// A copy with the same future; with `rekey`, it gets random numbers of its own.
  Simulation fork(bool rekey = false);

  /// Hash over all transitions since construction (or the restored snapshot): state words,
  /// observation, privileged row, images, reward and status. Under direct control, evaluate() adds
  /// a transition.
  std::uint64_t hash() const;
  /// Whether transitions are added to the hash (default: yes). It costs about as much as a light
  /// transition.
  void keep_hash(bool keep);

 private:
  void apply_requests();
  void touch() const;
  void demand_started(const char* call) const;
  int robot_index(const std::string& name) const;
  int body_index(const std::string& robot, const std::string& link) const;
  std::string rotor_path(const std::string& robot, int rotor, const std::string& name) const;
  void add_to_hash();
  std::shared_ptr<const CompiledScenario> compiled_;
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace skybody
