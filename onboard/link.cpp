#include "onboard/link.h"

#include <algorithm>

namespace skybody::onboard {

bool Link::receive(double now) {
  const auto packet = socket_.receive();
  if (packet) take(*packet, now);
  return packet.has_value();
}

void PacketLink::take(std::span<const char> packet, double now) {
  socket_.answer_sender();
  inbox_.take(packet, now);
}

void MavlinkLink::take(std::span<const char> packet, double now) {
  if (packet.size() >= sizeof kPacketMagic &&
      std::equal(std::begin(kPacketMagic), std::end(kPacketMagic), packet.begin())) {
    return inbox_.take(packet, now);
  }
  socket_.answer_sender();
  receiver_.take(packet, now);
}

void PacketLink::send(const Decision& decision, double stamp, double) {
  size_ = write_command(decision, signal_, stamp, sequence_++, packet_);
  repeat();
}

void PacketLink::repeat() { socket_.send({packet_, size_}); }

void MavlinkLink::send(const Decision& decision, double stamp, double now) {
  constexpr double kBeat = 1.0;  // [s]
  if (now - heartbeat_ >= kBeat) {
    heartbeat_ = now;
    socket_.send(sender_.heartbeat());
  }
  last_ = sender_.command(decision, stamp, receiver_.system(), receiver_.component());
  repeat();
}

}  // namespace skybody::onboard
