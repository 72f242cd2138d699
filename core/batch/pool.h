// Many environments of one scenario, stepped on several threads: the paper's asynchronous pool (its
// section IV-D). Results do not depend on threads, batches or order.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/system/error.h"
#include "core/batch/batch.h"
#include "core/batch/observer.h"
#include "core/batch/pool_options.h"
#include "core/env/compiled_scenario.h"
#include "core/env/state_values.h"

namespace skybody {

/// The call is not allowed in the Pool's current state, whatever its arguments: environments are in
/// flight, no hash is kept, or the Pool belongs to the parent process.
class StateError : public Error {
 public:
  using Error::Error;
};

/// N_E environments, N_T threads, batches of N_B. send() queues actions and returns; recv() waits
/// for N_B finished environments while the others continue. All methods belong to one thread at a
/// time. A fault in one environment ends its episode and does not affect the others.
///
/// An exception in a worker is rethrown by the next recv(). The Pool is then broken: every later
/// call throws the same exception. After a fork() of the process, calls in the child throw.
class Pool {
 public:
  /// @throws Error if an option is out of range
  Pool(std::shared_ptr<const CompiledScenario> compiled, const PoolOptions& options);
  /// Waits for running steps; queued steps that have not begun are dropped.
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  const CompiledScenario& compiled() const;
  const std::shared_ptr<const CompiledScenario>& shared_scenario() const;
  int envs() const;
  int batch() const;
  int threads() const;
  int lanes() const;           ///< environments that are stepped side by side, 1 ... 32
  int pinned_threads() const;  ///< workers that have a processor of their own
  const PoolOptions& options() const;

  /// Begins new episodes in all environments, or in those whose byte in `mask` is not 0; recv()
  /// returns their first observations. @throws Error if one of them is in flight
  void send_reset();
  void send_reset(std::span<const std::uint8_t> mask);
  /// Initializes every environment with another seed (episode counters start again), then resets
  /// all.
  void send_reset(std::uint64_t seed);

  /// Sends one action row per environment; the rows are copied before it returns.
  /// @param actions  rows of action_size() values in [-1, 1] (clipped); a row that is not finite
  ///   makes its transition a fault
  /// @param env_ids  ids of the environments, each at most once; empty: all N_E in order
  /// @throws Error if an id is out of range, listed twice, in flight, not yet reset, or (kDisabled)
  ///   its episode has ended; then nothing was sent
  void send(std::span<const float> actions, std::span<const std::int32_t> env_ids = {});

  /// N_B finished rows, or all that are in flight if these are fewer. The rows keep their values
  /// until the second next recv(), and as long as the pointer is held.
  /// @throws Error if nothing is in flight; a worker's exception
  std::shared_ptr<const Batch> recv();
  /// The same with a time limit: null if it expires; no rows are lost.
  std::shared_ptr<const Batch> recv(std::chrono::milliseconds patience);

  /// Whether a worker has thrown an exception: every call throws it from then on.
  bool broken() const;
  int in_flight() const;                ///< environments sent and not yet received
  std::uint64_t fresh_buffers() const;  ///< buffers made because the caller still held the old one
  std::uint64_t faults() const;         ///< faulted transitions received so far

  /// A snapshot of all environments, in order. @throws Error while some are in flight
  std::vector<std::uint64_t> save() const;
  /// @throws Error if `saved` does not match this scenario and number of environments, was changed
  ///   after save(), or environments are in flight; then nothing was restored
  void restore(std::span<const std::uint64_t> saved);
  /// Makes environments copies of `source`: same motion, drawn values, plugin states, future.
  /// @param rekey  each copy gets random numbers of its own
  /// @throws Error if an id is out of range or in flight
  void fork(int source, std::span<const std::int32_t> targets, bool rekey);

  /// Last observation of every environment.
  /// @param observation  N_E x observation_size(). @throws Error on another number of values
  void observations(std::span<float> observation) const;
  /// Last privileged row of every environment, N_E x privileged_size().
  void privileged(std::span<float> privileged) const;
  /// One of the observation's images (CompiledScenario::images) of every environment.
  /// @param pixels  N_E times its bytes. @throws Error on another size, or if there is no such
  ///   image
  void image(int image, std::span<std::uint8_t> pixels) const;
  /// A value of the state of every environment, such as robots.quad.base.position.
  /// CompiledScenario::state_values() lists all values with units, frames and shapes. Does not
  /// allocate.
  /// @param values  N_E x StateValue::count(), written
  /// @throws Error if there is no such value, on another number of values, or if an environment has
  ///   not begun an episode; StateError while some are in flight
  void state(std::string_view path, std::span<double> values) const;
  /// The task's goals in an environment: 4 values each, position (W) [m], yaw [rad].
  /// @throws Error as state()
  std::vector<double> goals(int env) const;
  /// Value of a randomizable parameter. @throws Error as Simulation::param
  double param(int env, const std::string& path) const;
  void set_param(int env, const std::string& path, double value);

  /// Requests values of randomizable parameters; environments may be in flight. A request takes
  /// effect with the next transition that is sent to an environment: before a step, or, if it is a
  /// reset, after the randomizers' draws there. Transitions already in flight are not affected.
  /// Several requests are applied in order. A requested value persists until a randomizer or
  /// another request writes it.
  /// @param when     kNextReset: at the next reset that is sent from now on, or that follows the
  ///   end of an episode in a transition sent from now on
  /// @param env_ids  as for send()
  /// @throws Error as ParamRequest, or if an id is out of range; then nothing was requested
  void request(std::span<const ParamChange> changes, RequestTime when,
               std::span<const std::int32_t> env_ids = {});
  /// Requests draws from all randomizers in the same way, regardless of their schedule.
  void randomize(RequestTime when, std::span<const std::int32_t> env_ids = {});

  /// Physics steps of all environments since the Pool was made, and the number of those with
  /// anything near a body. @throws Error while some are in flight
  StepCounts step_counts() const;

  /// Trajectory hash of one environment, and of all, combined in order of ids.
  /// @throws Error without keep_hash, or while some are in flight
  std::uint64_t hash(int env) const;
  std::uint64_t hash() const;

  /// Sets the observer of all events from now on, in place of the previous one; null: none. Hashes
  /// are kept while there is an observer. @throws Error if one is set while some are in flight
  void observe(std::shared_ptr<PoolObserver> observer);

 private:
  void ask(const PoolRequest& request);
  void check_started(const char* call, int env) const;
  class Scheduler;
  std::unique_ptr<Scheduler> scheduler_;
};

}  // namespace skybody
