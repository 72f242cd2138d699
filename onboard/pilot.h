// The policy of a mission with its observation, and the watch over both.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/policy/network_evaluator.h"
#include "onboard/mission.h"
#include "onboard/situation.h"
#include "onboard/task_host.h"

namespace skybody::onboard {

enum class Mode : std::uint32_t {
  kWaiting = 0,  ///< no pose yet: no command
  kPolicy = 1,   ///< the policy's command
  kSafe = 2,     ///< the safe command
  kStopped = 3,  ///< commands of zero
};

/// Reasons for the safe command, as bits.
enum Reason : std::uint32_t {
  kStale = 1,           ///< a pose is older than Limits::stale
  kTilt = 2,            ///< beyond Limits::tilt
  kFence = 4,           ///< outside of the fence
  kBadObservation = 8,  ///< the task made a value that is not finite
  kBadCommand = 16,     ///< the policy made a value that is not finite
  kLate = 32,           ///< a step came later than Limits::lateness
  kDisengaged = 64,     ///< switched off
};
/// The names of the bits of `reasons`, with commas.
std::string reason_text(std::uint32_t reasons);

/// Inputs of a step beside the situation.
struct Tick {
  double time = 0.0;          ///< of a clock that only grows [s]
  double age = 0.0;           ///< of the oldest needed pose [s]
  double lateness = 0.0;      ///< of this step behind its schedule [s]
  std::uint64_t periods = 1;  ///< since the last step: more than one if steps were left out
};

struct Decision {
  Mode mode = Mode::kWaiting;
  std::uint32_t reasons = 0;
  std::span<const float> action;    ///< of the robot, in [-1, 1]; zero unless the policy flies
  std::span<const double> command;  ///< in physical units
};

/// Decides on a command once a period. Does not allocate after its construction.
///
/// A violated limit switches to the safe command, which stays until engage(): the policy does not
/// take over again by itself.
class Pilot {
 public:
  /// @param mission  must outlive it. @throws Error as TaskHost
  explicit Pilot(const Mission& mission);

  Situation& situation() { return situation_; }
  const Mission& mission() const { return mission_; }

  /// The first pose is there: the policy flies from the next step on, from its first state.
  void engage();
  void disengage() { hand_over(kDisengaged); }
  Mode mode() const { return mode_; }

  Decision step(const Tick& tick);

 private:
  void hand_over(std::uint32_t reasons);
  std::uint32_t violations(const Tick& tick) const;
  std::uint32_t fly(const Tick& tick);
  void be_safe(const Tick& tick);

  const Mission& mission_;
  TaskHost task_;
  NetworkEvaluator network_;
  const PolicyAgent& agent_;
  Situation situation_;
  Mode mode_ = Mode::kWaiting;
  std::uint32_t reasons_ = 0;
  bool is_first_ = true;
  double safe_since_ = -1.0;
  std::vector<float> observation_, row_, action_, memory_;
  std::vector<double> command_;
};

}  // namespace skybody::onboard
