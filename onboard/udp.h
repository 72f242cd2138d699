// A UDP socket of IPv4.
#pragma once

#include <netinet/in.h>

#include <optional>
#include <span>
#include <string>

namespace skybody::onboard {

/// HOST:PORT, with a number as host. @throws Error
sockaddr_in address_of(const std::string& text);

class UdpSocket {
 public:
  /// Binds to an address; port 0: any that is free. @throws Error, such as that it is in use
  explicit UdpSocket(const sockaddr_in& address);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  int descriptor() const { return socket_; }
  int port() const;
  /// Answers go to this address, and packets of others are left out.
  void set_peer(const sockaddr_in& peer);
  /// A packet that has come, which is valid until the next call; nothing if there is none.
  std::optional<std::span<const char>> receive();
  /// Without set_peer(): answers go to the sender of the last received packet.
  void answer_sender();
  /// Sends to the peer, if there is one. @returns whether it was sent
  bool send(std::span<const char> packet);

 private:
  int socket_ = -1;
  bool is_fixed_ = false, has_peer_ = false;
  sockaddr_in peer_{}, sender_{};
  char bytes_[4096];
};

}  // namespace skybody::onboard
