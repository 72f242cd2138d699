#include "onboard/udp.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>

#include "core/base/system/error.h"

namespace skybody::onboard {
namespace {

std::string text_of(const sockaddr_in& address) {
  char host[INET_ADDRSTRLEN] = {};
  inet_ntop(AF_INET, &address.sin_addr, host, sizeof host);
  return std::string(host) + ":" + std::to_string(ntohs(address.sin_port));
}

}  // namespace

sockaddr_in address_of(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  sockaddr_in address{};
  address.sin_family = AF_INET;
  unsigned port = 65536;
  if (colon != std::string::npos) {
    const char *first = text.data() + colon + 1, *last = text.data() + text.size();
    const auto [end, error] = std::from_chars(first, last, port);
    if (error != std::errc{} || end != last) port = 65536;
  }
  if (port > 65535 || inet_pton(AF_INET, text.substr(0, colon).c_str(), &address.sin_addr) != 1) {
    throw Error("`" + text + "` is no address; allowed: HOST:PORT, such as 127.0.0.1:14650");
  }
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

UdpSocket::UdpSocket(const sockaddr_in& address) {
  socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const auto* bound = reinterpret_cast<const sockaddr*>(&address);
  if (socket_ >= 0 && bind(socket_, bound, sizeof address) == 0) return;
  const int problem = errno;
  if (socket_ >= 0) close(socket_);
  if (problem == EADDRINUSE) {
    throw Error(text_of(address) + " is in use; end the other program, or choose another port");
  }
  throw Error(text_of(address) + ": " + std::strerror(problem));
}

UdpSocket::~UdpSocket() { close(socket_); }

int UdpSocket::port() const {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

void UdpSocket::set_peer(const sockaddr_in& peer) {
  peer_ = peer;
  is_fixed_ = has_peer_ = true;
}

std::optional<std::span<const char>> UdpSocket::receive() {
  while (true) {
    socklen_t size = sizeof sender_;
    const ssize_t count =
        recvfrom(socket_, bytes_, sizeof bytes_, 0, reinterpret_cast<sockaddr*>(&sender_), &size);
    if (count < 0) {
      if (errno == EINTR || errno == ECONNREFUSED) continue;  // a peer has gone away
      return std::nullopt;
    }
    const bool is_peer =
        sender_.sin_addr.s_addr == peer_.sin_addr.s_addr && sender_.sin_port == peer_.sin_port;
    if (is_fixed_ && !is_peer) continue;
    return std::span<const char>(bytes_, static_cast<std::size_t>(count));
  }
}

void UdpSocket::answer_sender() {
  if (!is_fixed_) peer_ = sender_;
  has_peer_ = true;
}

bool UdpSocket::send(std::span<const char> packet) {
  if (!has_peer_) return false;
  const auto* to = reinterpret_cast<const sockaddr*>(&peer_);
  return sendto(socket_, packet.data(), packet.size(), MSG_NOSIGNAL, to, sizeof peer_) ==
         static_cast<ssize_t>(packet.size());
}

}  // namespace skybody::onboard
