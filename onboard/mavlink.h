// The messages of MAVLink that a vehicle's estimator sends and takes, by a table.
//
// Only framing and the fields that are used are here: the common dialect's messages with their
// numbers, sizes and CRC seeds (https://mavlink.io/en/messages/common.html).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "onboard/inbox.h"
#include "onboard/pilot.h"

namespace skybody::onboard::mavlink {

/// Numbers of messages.
enum Id : std::uint32_t {
  kHeartbeat = 0,
  kAttitudeQuaternion = 31,
  kLocalPositionNed = 32,
  kSetAttitudeTarget = 82,
  kSetPositionTargetLocalNed = 84,
  kHighresImu = 105,
  kSetActuatorControlTarget = 139,
  kOdometry = 331,
};

/// A message's payload with the zeros that senders cut off.
struct Message {
  std::uint32_t id = 0;
  std::uint8_t system = 0, component = 0;
  std::uint8_t payload[255] = {};
};

/// Messages of a datagram, MAVLink 1 or 2; damaged and unknown ones are left out.
class Parser {
 public:
  explicit Parser(std::span<const char> bytes) : rest_(bytes) {}
  /// The next message, or nothing at the end.
  std::optional<Message> next();
  std::size_t bad() const { return bad_; }  ///< messages with a wrong checksum, and cut ones

 private:
  std::span<const char> rest_;
  std::size_t bad_ = 0;
};

/// Feeds an inbox from messages about one vehicle. NED and FRD become our axes (docs/onboard.md).
class Receiver {
 public:
  explicit Receiver(Inbox& inbox) : inbox_(inbox) {}
  void take(std::span<const char> bytes, double now);
  std::uint8_t system() const { return system_; }  ///< of the last heartbeat; 1 before it
  std::uint8_t component() const { return component_; }

 private:
  void take(const Message& message, double now);
  void take_odometry(const Message& message, double now);
  void take_attitude(const Message& message, double now);

  Inbox& inbox_;
  std::uint8_t system_ = 1, component_ = 1;
  Motion local_;              ///< position and velocity of LOCAL_POSITION_NED
  double local_time_ = -1e9;  ///< [s] of the receiver's clock
};

/// A message of MAVLink 2 from our system and component, without the zeros at the payload's end.
std::string framed(std::uint32_t id, const std::string& payload, std::uint8_t sequence);

/// Makes messages with our numbers of system and component.
class Sender {
 public:
  /// @throws Error if no message carries the mission's command
  explicit Sender(const Mission& mission);
  /// The message of a command. @param stamp  of the newest pose [s]
  std::string command(const Decision& decision, double stamp, std::uint8_t system,
                      std::uint8_t component);
  std::string heartbeat();

 private:
  std::string attitude_target(std::span<const double> c, std::uint32_t millis) const;
  std::string position_target(std::span<const double> c, std::uint32_t millis) const;
  std::string actuators(std::span<const double> c, std::uint64_t micros) const;

  const Mission& mission_;
  int signal_;
  std::uint8_t sequence_ = 0;
};

}  // namespace skybody::onboard::mavlink
