#include "onboard/packets.h"

#include <cstring>

namespace skybody::onboard {

std::size_t write_command(const Decision& decision, int signal, double stamp,
                          std::uint32_t sequence, std::span<char> to) {
  const std::size_t actions = decision.action.size(), commands = decision.command.size();
  const std::size_t floats = 4 * (actions + actions % 2),
                    size = sizeof(CommandHead) + floats + 8 * commands;
  if (size > to.size()) return 0;
  CommandHead head{};
  std::memcpy(head.header.magic, kPacketMagic, sizeof kPacketMagic);
  head.header.version = kPacketVersion;
  head.header.type = static_cast<std::uint8_t>(PacketType::kCommand);
  head.header.size = static_cast<std::uint16_t>(size);
  head.header.sequence = sequence;
  head.header.stamp = stamp;
  head.mode = static_cast<std::uint32_t>(decision.mode);
  head.reasons = decision.reasons;
  head.signal = static_cast<std::uint32_t>(signal);
  head.actions = static_cast<std::uint16_t>(actions);
  head.commands = static_cast<std::uint16_t>(commands);
  std::memset(to.data(), 0, size);
  std::memcpy(to.data(), &head, sizeof head);
  std::memcpy(to.data() + sizeof head, decision.action.data(), 4 * actions);
  std::memcpy(to.data() + sizeof head + floats, decision.command.data(), 8 * commands);
  return size;
}

}  // namespace skybody::onboard
