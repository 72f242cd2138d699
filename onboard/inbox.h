// Takes received values in order of their stamps, and tells how old they are.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "onboard/needs.h"
#include "onboard/pilot.h"

namespace skybody::onboard {

/// Why a packet was not used.
enum class Refusal : std::uint8_t {
  kShort,    ///< cut short, or longer than its type
  kForeign,  ///< another magic, version or type
  kLate,     ///< older than the last of its kind
  kBad,      ///< a value that is not finite, or no unit quaternion
  kUnknown,  ///< no such body, parameter or frame
  kCount,
};

/// Packets of a flight, for the last lines of the program.
struct PacketCounts {
  std::uint64_t taken = 0;
  std::array<std::uint64_t, static_cast<std::size_t>(Refusal::kCount)> refused{};
  std::uint64_t all_refused() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t count : refused) sum += count;
    return sum;
  }
};

class Inbox {
 public:
  /// @param in_lockstep  ages are those of the stamps, and the receiver's clock does not count
  /// @param engages  whether the policy takes over with the first complete set of values
  Inbox(Pilot& pilot, const Needs& needs, bool in_lockstep, bool engages);

  /// Reads one of our packets. @param now  [s] of the receiver's clock
  void take(std::span<const char> packet, double now);
  /// A pose. @param body  world body index; -1: the vehicle's base
  /// @returns whether it is newer than the last one
  bool take_motion(int body, const Motion& motion, double stamp, double now);
  /// A sample of an IMU. @param stamp  of the sender's clock [s]
  void take_imu(const Imu& imu, double stamp, double now);
  /// Counts a packet that is not used, and reports the first one of its kind.
  void refuse(Refusal why, const std::string& problem);

  /// Whether everything that the observation needs has come.
  bool is_complete() const;
  /// Lets the policy take over if that is wanted and everything has come.
  void engage_if_wanted();
  /// Age of the oldest needed value, by the receiver's clock [s].
  double age(double now) const;
  /// The stamp of the newest pose of the base [s].
  double stamp() const { return base_.stamp; }
  /// Poses of the base so far.
  std::uint64_t poses() const { return poses_; }
  /// A pose of the base came again: in lockstep its answer was lost.
  bool take_repeat();

  const PacketCounts& counts() const { return counts_; }

 private:
  /// Arrival of values of one kind.
  struct Arrival {
    double stamp = 0.0, time = 0.0;
    bool is_there = false;
  };
  bool is_newer(Arrival& last, double stamp, double now);
  void take_state(std::span<const char> packet, double now);
  void take_param(std::span<const char> packet);
  void take_control(bool engages);

  Pilot& pilot_;
  std::vector<int> bodies_;
  std::vector<Arrival> others_;  ///< of bodies_
  Arrival base_, imu_;
  bool in_lockstep_, wants_engage_, needs_imu_, is_repeat_ = false;
  std::uint64_t poses_ = 0;
  PacketCounts counts_;
};

}  // namespace skybody::onboard
