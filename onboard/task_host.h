// Runs a task of the simulator on a vehicle: the same code makes the policy's observation.
//
// The task is configured by the mission's copy of the world that it had at its export, and is
// evaluated for one environment, whose bodies, sensors and parameters are those of a Situation.
// Accesses are checked as in the engine's checked mode: a damaged mission reads no foreign memory.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/plugin_abi/abi.h"
#include "onboard/mission.h"
#include "onboard/situation.h"

namespace skybody::onboard {

/// The task of that name in this program. @returns null if there is none
const SkybodyPlugin* find_task(const std::string& name);
/// Names of the tasks in this program.
std::vector<std::string> task_names();

/// Declarations of a task, as far as its memory and its action are concerned.
struct TaskSizes {
  int buffer = 0, scratch = 0, memo = 0;  ///< doubles
  int observation = 0, info = 0;          ///< values
  bool has_own_action = false, has_period = false;
  std::string missing;  ///< something that a vehicle cannot give, such as contacts; empty: nothing
};

class TaskHost {
 public:
  /// @throws Error if this program does not have the task, or the task refuses its setup
  explicit TaskHost(const Mission& mission);
  ~TaskHost();
  TaskHost(const TaskHost&) = delete;
  TaskHost& operator=(const TaskHost&) = delete;

  /// Begins a flight: resets the task's memory. Call observe() next, with `step` 0.
  void reset(const Situation& situation);
  /// Writes the policy's row of observations. Does not allocate.
  /// @param action  the last action, all of the row; at step 0 it is not used
  void observe(const Situation& situation, std::span<const float> action,
               std::span<float> observation);
  /// Writes the command of the robot in physical units, chain().count values. Does not allocate.
  void command(const Situation& situation, std::span<const float> action,
               std::span<double> command);

 private:
  SkybodyLanes lanes(const Situation& situation);
  void keep_files();
  void create();
  std::uint64_t* words() { return state_.data(); }
  double* buffer() { return reinterpret_cast<double*>(state_.data() + plugin_->state_words); }

  const Mission& mission_;
  const SkybodyPlugin* plugin_ = nullptr;
  SkybodyKernels kernels_{};
  SetupCopy setup_;
  TaskSizes sizes_;
  void* self_ = nullptr;
  std::vector<int> files_;  ///< descriptors of the mission's files
  std::vector<std::uint64_t> state_;
  std::vector<double> scratch_, memo_, values_, info_, robot_reward_, action_, command_, scaled_;
  std::uint64_t key_[2] = {};
  std::uint64_t episode_ = 1, step_ = 0, physics_step_ = 0;
  SkybodyChecks checks_{};
};

}  // namespace skybody::onboard
