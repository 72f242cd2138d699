#include "onboard/inbox.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "onboard/packets.h"

namespace skybody::onboard {
namespace {

constexpr double kForgotten = 1.0;  // [s] of silence after which a sender's clock may begin anew

/// Reads a structure from the beginning of a packet, which is long enough.
template <class T>
T read(std::span<const char> packet) {
  T value;
  std::memcpy(&value, packet.data(), sizeof(T));
  return value;
}

std::size_t size_of(PacketType type) {
  switch (type) {
    case PacketType::kState:
      return sizeof(StatePacket);
    case PacketType::kImu:
      return sizeof(ImuPacket);
    case PacketType::kParam:
      return sizeof(ParamPacket);
    case PacketType::kControl:
      return sizeof(ControlPacket);
    default:
      return 0;
  }
}

Vec3<double> vec3(const double* v) { return {v[0], v[1], v[2]}; }

}  // namespace

Inbox::Inbox(Pilot& pilot, const Needs& needs, bool in_lockstep, bool engages)
    : pilot_(pilot),
      bodies_(needs.bodies),
      others_(needs.bodies.size()),
      in_lockstep_(in_lockstep),
      wants_engage_(engages),
      needs_imu_(needs.imu) {}

void Inbox::refuse(Refusal why, const std::string& problem) {
  std::uint64_t& count = counts_.refused[static_cast<std::size_t>(why)];
  if (count++ == 0)
    std::fprintf(stderr, "packet: %s; ignored, as are others of this kind\n", problem.c_str());
}

void Inbox::take(std::span<const char> packet, double now) {
  if (packet.size() < sizeof(PacketHeader)) {
    return refuse(Refusal::kShort, "it has " + std::to_string(packet.size()) + " bytes");
  }
  const auto header = read<PacketHeader>(packet);
  const auto type = static_cast<PacketType>(header.type);
  const std::size_t size = size_of(type);
  if (std::memcmp(header.magic, kPacketMagic, sizeof kPacketMagic) != 0 ||
      header.version != kPacketVersion || size == 0) {
    return refuse(Refusal::kForeign, "it is none of ours (magic, version or type)");
  }
  if (packet.size() != size || header.size != size) {
    return refuse(Refusal::kShort, "it has " + std::to_string(packet.size()) +
                                       " bytes; its type has " + std::to_string(size));
  }
  if (!std::isfinite(header.stamp)) return refuse(Refusal::kBad, "its stamp is not finite");
  if (type == PacketType::kState) return take_state(packet, now);
  if (type == PacketType::kParam) return take_param(packet);
  if (type == PacketType::kImu) {
    const auto p = read<ImuPacket>(packet);
    return take_imu({vec3(p.specific_force), vec3(p.angular_velocity)}, header.stamp, now);
  }
  ++counts_.taken;
  take_control(read<ControlPacket>(packet).engage != 0);
}

/// The policy takes over with values that come after the packet, whose stamps may begin anew.
void Inbox::take_control(bool engages) {
  wants_engage_ = engages;
  if (!engages) return pilot_.disengage();
  base_.is_there = imu_.is_there = false;
  for (Arrival& other : others_) other.is_there = false;
}

void Inbox::engage_if_wanted() {
  if (!wants_engage_ || !is_complete()) return;
  wants_engage_ = false;
  pilot_.engage();
}

void Inbox::take_state(std::span<const char> packet, double now) {
  const auto p = read<StatePacket>(packet);
  const double* v = p.values;
  const Motion motion{vec3(v), {v[3], v[4], v[5], v[6]}, vec3(v + 7), vec3(v + 10)};
  take_motion(p.body, motion, p.header.stamp, now);
}

void Inbox::take_param(std::span<const char> packet) {
  auto p = read<ParamPacket>(packet);
  p.path[sizeof p.path - 1] = '\0';
  const bool are_finite = std::all_of(std::begin(p.values), std::end(p.values),
                                      [](double value) { return std::isfinite(value); });
  if (p.count < 1 || p.count > kParamValues || !are_finite) {
    return refuse(Refusal::kBad, "a parameter's values are not finite, or more than 8");
  }
  const std::span values(p.values, p.count);
  if (!pilot_.situation().set_param(pilot_.mission(), p.path, values)) {
    return refuse(Refusal::kUnknown, "the mission has no such parameter");
  }
  ++counts_.taken;
}

bool Inbox::is_newer(Arrival& last, double stamp, double now) {
  const bool is_silent = !in_lockstep_ && now - last.time >= kForgotten;
  if (last.is_there && stamp <= last.stamp && !is_silent) {
    is_repeat_ |= &last == &base_ && stamp == last.stamp;
    refuse(Refusal::kLate, "its stamp is not after that of the last one");
    return false;
  }
  last = {stamp, in_lockstep_ ? stamp : now, true};
  ++counts_.taken;
  return true;
}

bool Inbox::take_motion(int body, const Motion& motion, double stamp, double now) {
  const int base = pilot_.mission().vehicle().first_body;
  if (body < 0) body = base;
  const auto other = std::find(bodies_.begin(), bodies_.end(), body);
  if (body >= pilot_.situation().body_count()) {
    refuse(Refusal::kUnknown, "the mission has no body " + std::to_string(body));
    return false;
  }
  if (body != base && other == bodies_.end()) return false;  // not needed
  if (!motion.is_valid()) {
    refuse(Refusal::kBad, "a pose is not finite, or its quaternion has not the length 1");
    return false;
  }
  Arrival& last = body == base ? base_ : others_[static_cast<std::size_t>(other - bodies_.begin())];
  if (!is_newer(last, stamp, now)) return false;
  pilot_.situation().set_body(body, motion);
  poses_ += body == base ? 1 : 0;
  return true;
}

void Inbox::take_imu(const Imu& imu, double stamp, double now) {
  const auto& f = imu.specific_force;
  const auto& w = imu.angular_velocity;
  if (!std::isfinite(f.x + f.y + f.z + w.x + w.y + w.z)) {
    return refuse(Refusal::kBad, "a value of the IMU is not finite");
  }
  if (is_newer(imu_, stamp, now)) pilot_.situation().set_imu(pilot_.mission(), imu);
}

bool Inbox::is_complete() const {
  const bool others =
      std::all_of(others_.begin(), others_.end(), [](const Arrival& a) { return a.is_there; });
  return base_.is_there && others && (!needs_imu_ || imu_.is_there);
}

double Inbox::age(double now) const {
  double oldest = base_.time;
  for (const Arrival& other : others_) oldest = std::min(oldest, other.time);
  if (needs_imu_) oldest = std::min(oldest, imu_.time);
  return now - oldest;
}

bool Inbox::take_repeat() {
  const bool repeat = is_repeat_;
  is_repeat_ = false;
  return repeat;
}

}  // namespace skybody::onboard
