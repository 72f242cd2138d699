// The vehicle's side of a flight: poses come in, commands go out.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "onboard/inbox.h"
#include "onboard/mavlink.h"
#include "onboard/packets.h"
#include "onboard/udp.h"

namespace skybody::onboard {

class Link {
 public:
  explicit Link(UdpSocket& socket) : socket_(socket) {}
  virtual ~Link() = default;
  int descriptor() const { return socket_.descriptor(); }
  /// Feeds the inbox with a packet that has come. @param now  of the receiver's clock [s]
  /// @returns whether there was one
  bool receive(double now);
  /// Sends the command of a step. @param stamp  of the newest pose [s]
  virtual void send(const Decision& decision, double stamp, double now) = 0;
  /// Sends the last command again.
  virtual void repeat() = 0;

 protected:
  virtual void take(std::span<const char> packet, double now) = 0;
  UdpSocket& socket_;
};

/// Our own packets (packets.h).
class PacketLink : public Link {
 public:
  PacketLink(UdpSocket& socket, Inbox& inbox, const Mission& mission)
      : Link(socket), inbox_(inbox), signal_(mission.chain().signal) {}
  void send(const Decision& decision, double stamp, double now) override;
  void repeat() override;

 private:
  void take(std::span<const char> packet, double now) override;
  Inbox& inbox_;
  int signal_;
  std::uint32_t sequence_ = 0;
  std::size_t size_ = 0;
  char packet_[kLargestPacket] = {};
};

/// MAVLink (mavlink.h), with a heartbeat each second. Also takes our own packets, such as those
/// that engage the policy; answers go to the sender of MAVLink.
class MavlinkLink : public Link {
 public:
  /// @throws Error as mavlink::Sender
  MavlinkLink(UdpSocket& socket, Inbox& inbox, const Mission& mission)
      : Link(socket), inbox_(inbox), receiver_(inbox), sender_(mission) {}
  void send(const Decision& decision, double stamp, double now) override;
  void repeat() override { socket_.send(last_); }

 private:
  void take(std::span<const char> packet, double now) override;
  Inbox& inbox_;
  mavlink::Receiver receiver_;
  mavlink::Sender sender_;
  std::string last_;
  double heartbeat_ = -1e9;  ///< time of the last one [s]
};

}  // namespace skybody::onboard
