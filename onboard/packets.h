// Our own UDP packets (docs/onboard.md). Little-endian; a header of 24 bytes, then the content.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "onboard/pilot.h"

namespace skybody::onboard {

inline constexpr char kPacketMagic[4] = {'S', 'K', 'Y', 'B'};
inline constexpr std::uint8_t kPacketVersion = 1;
inline constexpr std::size_t kLargestPacket = 2048;  // [bytes]

enum class PacketType : std::uint8_t {
  kState = 1,     ///< pose and twist of a body
  kImu = 2,       ///< specific force and angular velocity
  kParam = 3,     ///< values of the task, such as its target
  kControl = 4,   ///< switches the policy on or off
  kCommand = 16,  ///< the answer
};

struct PacketHeader {
  char magic[4];
  std::uint8_t version, type;
  std::uint16_t size;  ///< of the whole packet [bytes]
  std::uint32_t sequence, zero;
  double stamp;  ///< of the sender's clock [s]
};
static_assert(sizeof(PacketHeader) == 24);

struct StatePacket {
  PacketHeader header;
  std::int32_t body;  ///< world body index; -1: the vehicle's base
  std::uint32_t zero;
  double values[kBodyValues];  ///< position (W), quaternion w x y z, velocity (W), rate (B)
};
static_assert(sizeof(StatePacket) == 136);

struct ImuPacket {
  PacketHeader header;
  double specific_force[3], angular_velocity[3];  ///< B [m/s^2], [rad/s]
};
static_assert(sizeof(ImuPacket) == 72);

inline constexpr std::size_t kParamValues = 8;
struct ParamPacket {
  PacketHeader header;
  char path[64];  ///< such as task.target; ends with a zero byte
  std::uint32_t count, zero;
  double values[kParamValues];
};
static_assert(sizeof(ParamPacket) == 160);

struct ControlPacket {
  PacketHeader header;
  std::uint32_t engage;  ///< 1: the policy takes over, from its first state; 0: the safe command
  std::uint32_t zero;
};
static_assert(sizeof(ControlPacket) == 32);

/// Followed by `actions` floats, a zero float if their number is odd, and `commands` doubles.
struct CommandHead {
  PacketHeader header;  ///< stamp: that of the newest pose
  std::uint32_t mode, reasons;
  std::uint32_t signal;  ///< SkybodySignal of the command
  std::uint16_t actions, commands;
};
static_assert(sizeof(CommandHead) == 40);

/// Writes the answer of a step. @returns its size in bytes; 0: it does not fit into `to`
std::size_t write_command(const Decision& decision, int signal, double stamp,
                          std::uint32_t sequence, std::span<char> to);

}  // namespace skybody::onboard
