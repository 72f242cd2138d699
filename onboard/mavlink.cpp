#include "onboard/mavlink.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/constants.h"
#include "core/plugin_abi/signals.h"

namespace skybody::onboard::mavlink {
namespace {

struct Row {
  std::uint32_t id;
  std::uint8_t seed;   ///< of the checksum
  std::uint8_t least;  ///< bytes of the payload without extensions
};
constexpr Row kTable[] = {
    {kHeartbeat, 50, 9},
    {kAttitudeQuaternion, 246, 32},
    {kLocalPositionNed, 185, 28},
    {kSetAttitudeTarget, 49, 39},
    {kSetPositionTargetLocalNed, 143, 53},
    {kHighresImu, 93, 62},
    {kSetActuatorControlTarget, 168, 43},
    {kOdometry, 91, 230},
};

const Row* row_of(std::uint32_t id) {
  const auto row =
      std::find_if(std::begin(kTable), std::end(kTable), [id](const Row& r) { return r.id == id; });
  return row == std::end(kTable) ? nullptr : row;
}

/// CRC-16/MCRF4XX of one more byte.
std::uint16_t add_to_crc(std::uint16_t crc, std::uint8_t byte) {
  auto t = static_cast<std::uint8_t>(byte ^ (crc & 0xff));
  t = static_cast<std::uint8_t>(t ^ (t << 4));
  return static_cast<std::uint16_t>((crc >> 8) ^ (t << 8) ^ (t << 3) ^ (t >> 4));
}

std::uint16_t crc_of(std::span<const char> bytes, std::uint8_t seed) {
  std::uint16_t crc = 0xffff;
  for (const char byte : bytes) crc = add_to_crc(crc, static_cast<std::uint8_t>(byte));
  return add_to_crc(crc, seed);
}

template <class T>
T at(const Message& m, std::size_t offset) {
  T value;
  std::memcpy(&value, m.payload + offset, sizeof(T));
  return value;
}
double real(const Message& m, std::size_t offset) {
  return static_cast<double>(at<float>(m, offset));
}
Vec3<double> vec3(const Message& m, std::size_t offset) {
  return {real(m, offset), real(m, offset + 4), real(m, offset + 8)};
}

/// From NED to W, or from FRD to B; also the reverse.
Vec3<double> flip(const Vec3<double>& v) { return {v.x, -v.y, -v.z}; }
Quat<double> flip(const Quat<double>& q) { return {q.w, q.x, -q.y, -q.z}; }

/// The quaternion of four floats, with the length 1 to the last bits of a double.
Quat<double> quat(const Message& m, std::size_t offset) {
  const Quat<double> q = flip(Quat<double>{real(m, offset), real(m, offset + 4),
                                           real(m, offset + 8), real(m, offset + 12)});
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(std::abs(length - 1.0) < 0.005)) return q;  // refused by Motion::is_valid()
  return {q.w / length, q.x / length, q.y / length, q.z / length};
}

template <class T>
void append(std::string& payload, T value) {
  payload.append(reinterpret_cast<const char*>(&value), sizeof(T));
}
void append(std::string& payload, const Vec3<double>& v) {
  for (const double value : {v.x, v.y, v.z}) append(payload, static_cast<float>(value));
}

constexpr std::uint8_t kOurSystem = 1, kOurComponent = 191;  // MAV_COMP_ID_ONBOARD_COMPUTER
constexpr std::uint8_t kLocalNed = 1, kBodyNed = 8, kBodyFrd = 12, kLocalFrd = 20;  // MAV_FRAME
constexpr double kPairTime = 0.1;  // [s] between the position and the attitude of a pose
constexpr std::size_t kMotors = 8;

// Bits of SET_POSITION_TARGET_LOCAL_NED.type_mask: fields that do not count, and `force`.
constexpr std::uint16_t kNoPosition = 7, kNoVelocity = 56, kNoAcceleration = 448, kIsForce = 512,
                        kNoYaw = 1024, kNoYawRate = 2048;

}  // namespace

std::optional<Message> Parser::next() {
  while (!rest_.empty()) {
    const auto magic = static_cast<std::uint8_t>(rest_[0]);
    if (magic != 0xfd && magic != 0xfe) {
      rest_ = rest_.subspan(1);
      continue;
    }
    const bool is_second = magic == 0xfd;
    const std::size_t head = is_second ? 10 : 6;
    if (rest_.size() < head + 2) break;
    const auto byte = [this](std::size_t k) { return static_cast<std::uint8_t>(rest_[k]); };
    const std::size_t length = byte(1);
    const bool is_signed = is_second && (byte(2) & 1) != 0;
    const std::size_t size = head + length + 2 + (is_signed ? 13 : 0);
    if (rest_.size() < size) break;
    const std::size_t system = is_second ? 5 : 3;
    Message m;
    m.system = byte(system);
    m.component = byte(system + 1);
    m.id = is_second ? byte(7) | byte(8) << 8 | static_cast<std::uint32_t>(byte(9)) << 16 : byte(5);
    std::memcpy(m.payload, rest_.data() + head, length);
    const Row* row = row_of(m.id);
    const auto sum = static_cast<std::uint16_t>(byte(head + length) | byte(head + length + 1) << 8);
    const bool is_whole =
        row != nullptr && crc_of(rest_.subspan(1, head - 1 + length), row->seed) == sum;
    if (row != nullptr && !is_whole) ++bad_;
    rest_ = rest_.subspan(row == nullptr || is_whole ? size : 1);
    if (is_whole) return m;
  }
  if (!rest_.empty()) ++bad_;  // cut short
  rest_ = {};
  return std::nullopt;
}

void Receiver::take(std::span<const char> bytes, double now) {
  Parser parser(bytes);
  while (const std::optional<Message> message = parser.next()) take(*message, now);
  if (parser.bad() > 0) inbox_.refuse(Refusal::kShort, "it has a damaged message of MAVLink");
}

void Receiver::take(const Message& m, double now) {
  switch (m.id) {
    case kHeartbeat:
      system_ = m.system;
      component_ = m.component;
      return;
    case kOdometry:
      return take_odometry(m, now);
    case kLocalPositionNed:
      local_.position = flip(vec3(m, 4));
      local_.velocity = flip(vec3(m, 16));
      local_time_ = now;
      return;
    case kAttitudeQuaternion:
      return take_attitude(m, now);
    case kHighresImu: {
      const Imu imu{flip(vec3(m, 8)), flip(vec3(m, 20))};
      return inbox_.take_imu(imu, 1e-6 * static_cast<double>(at<std::uint64_t>(m, 0)), now);
    }
    default:
      return;  // commands are not for us
  }
}

void Receiver::take_odometry(const Message& m, double now) {
  const auto frame = at<std::uint8_t>(m, 228), child = at<std::uint8_t>(m, 229);
  const bool is_ours = (frame == kLocalNed || frame == kLocalFrd) &&
                       (child == kBodyFrd || child == kBodyNed || child == kLocalNed);
  if (!is_ours) {
    return inbox_.refuse(Refusal::kUnknown, "ODOMETRY has frames " + std::to_string(frame) +
                                                " and " + std::to_string(child) +
                                                "; allowed: 1 or 20 and 12, 8 or 1");
  }
  Motion motion;
  motion.position = flip(vec3(m, 8));
  motion.rotation = quat(m, 20);
  motion.velocity = flip(vec3(m, 36));
  if (child != kLocalNed) motion.velocity = rotate(motion.rotation, motion.velocity);
  motion.angular_velocity = flip(vec3(m, 48));
  inbox_.take_motion(-1, motion, 1e-6 * static_cast<double>(at<std::uint64_t>(m, 0)), now);
}

/// The attitude completes a pose, with the last position.
void Receiver::take_attitude(const Message& m, double now) {
  if (now - local_time_ > kPairTime) return;
  Motion motion = local_;
  motion.rotation = quat(m, 4);
  motion.angular_velocity = flip(vec3(m, 20));
  inbox_.take_motion(-1, motion, 1e-3 * static_cast<double>(at<std::uint32_t>(m, 0)), now);
}

Sender::Sender(const Mission& mission) : mission_(mission), signal_(mission.chain().signal) {
  switch (signal_) {
    case SKYBODY_CTBR:
    case SKYBODY_ATTITUDE:
    case SKYBODY_FORCE:
    case SKYBODY_ACCELERATION:
    case SKYBODY_VELOCITY_TRACKING:
    case SKYBODY_POSITION:
      return;
    case SKYBODY_ROTOR_SPEED:
    case SKYBODY_SRT:
    case SKYBODY_THROTTLE:
      if (mission.vehicle().rotor_count <= static_cast<int>(kMotors)) return;
      [[fallthrough]];
    default:
      throw Error(
          "no message of MAVLink carries the command of this policy; use our UDP packets, or train "
          "a policy for ctbr, attitude, force, acceleration, velocity_tracking or up to 8 rotors");
  }
}

std::string framed(std::uint32_t id, const std::string& payload, std::uint8_t sequence) {
  std::size_t length = payload.size();
  while (length > 1 && payload[length - 1] == '\0') --length;
  std::string out = {'\xfd',
                     static_cast<char>(length),
                     0,
                     0,
                     static_cast<char>(sequence),
                     static_cast<char>(kOurSystem),
                     static_cast<char>(kOurComponent)};
  for (int k = 0; k < 3; ++k) out += static_cast<char>(id >> (8 * k));
  out.append(payload, 0, length);
  append(out, crc_of(std::span(out).subspan(1), row_of(id)->seed));
  return out;
}

std::string Sender::heartbeat() {
  std::string payload;
  append(payload, std::uint32_t{0});
  // MAV_TYPE_ONBOARD_CONTROLLER, MAV_AUTOPILOT_INVALID, no mode, MAV_STATE_ACTIVE, version 3
  for (const std::uint8_t byte : {18, 8, 0, 4, 3}) append(payload, byte);
  return framed(kHeartbeat, payload, sequence_++);
}

std::string Sender::attitude_target(std::span<const double> c, std::uint32_t millis) const {
  const bool is_attitude = signal_ == SKYBODY_ATTITUDE;
  const Quat<double> q =
      is_attitude ? flip(Quat<double>{c[1], c[2], c[3], c[4]}) : Quat<double>{1.0, 0.0, 0.0, 0.0};
  const std::size_t rates = is_attitude ? 5 : 1;
  const bool has_rates = c.size() >= rates + 3;
  const Vec3<double> w = has_rates ? flip(Vec3<double>{c[rates], c[rates + 1], c[rates + 2]})
                                   : Vec3<double>{0.0, 0.0, 0.0};
  std::string payload;
  append(payload, millis);
  for (const double value : {q.w, q.x, q.y, q.z}) append(payload, static_cast<float>(value));
  append(payload, w);
  append(payload, static_cast<float>(std::clamp(c[0] / mission_.largest_thrust(), 0.0, 1.0)));
  return payload;
}

std::string Sender::position_target(std::span<const double> c, std::uint32_t millis) const {
  const Vec3<double> zero{0.0, 0.0, 0.0}, first = flip(Vec3<double>{c[0], c[1], c[2]});
  const bool is_position = signal_ == SKYBODY_POSITION;
  const bool is_velocity = signal_ == SKYBODY_VELOCITY_TRACKING;
  const bool is_last = !is_position && !is_velocity;
  const double last = c.size() > 3 ? -c[3] : 0.0;  // yaw or its rate, clockwise
  std::string payload;
  append(payload, millis);
  append(payload, is_position ? first : zero);
  append(payload, is_velocity ? first : zero);
  append(payload, is_last ? first : zero);
  append(payload, static_cast<float>(is_velocity ? 0.0 : last));
  append(payload, static_cast<float>(is_velocity ? last : 0.0));
  int mask = is_velocity ? kNoYaw : kNoYawRate;
  if (c.size() < 4) mask |= kNoYaw;
  if (!is_position) mask |= kNoPosition;
  if (!is_velocity) mask |= kNoVelocity;
  if (!is_last) mask |= kNoAcceleration;
  if (signal_ == SKYBODY_FORCE) mask |= kIsForce;
  append(payload, static_cast<std::uint16_t>(mask));
  return payload;
}

/// Shares of the rotors' largest speeds.
std::string Sender::actuators(std::span<const double> c, std::uint64_t micros) const {
  std::string payload;
  append(payload, micros);
  for (std::size_t k = 0; k < kMotors; ++k) {
    double share = k < c.size() ? c[k] : 0.0;
    if (k < c.size() && signal_ != SKYBODY_THROTTLE) {
      const auto rotor = static_cast<std::size_t>(mission_.vehicle().first_rotor) + k;
      const double* constants = mission_.setup.rotors()[rotor].constants;
      share = signal_ == SKYBODY_ROTOR_SPEED
                  ? share / constants[SKYBODY_ROTOR_MAX_SPEED]
                  : std::sqrt(std::max(0.0, share / mission_.largest_thrust(static_cast<int>(k))));
    }
    append(payload, static_cast<float>(std::clamp(share, 0.0, 1.0)));
  }
  append(payload, std::uint8_t{0});  // group: motors
  return payload;
}

std::string Sender::command(const Decision& decision, double stamp, std::uint8_t system,
                            std::uint8_t component) {
  const auto micros = static_cast<std::uint64_t>(std::max(0.0, 1e6 * stamp));
  const auto millis = static_cast<std::uint32_t>(micros / 1000);
  const std::span<const double> c = decision.command;
  std::string payload;
  std::uint32_t id = kSetAttitudeTarget;
  if (signal_ == SKYBODY_CTBR || signal_ == SKYBODY_ATTITUDE) {
    payload = attitude_target(c, millis);
  } else if (signal_ == SKYBODY_ROTOR_SPEED || signal_ == SKYBODY_SRT ||
             signal_ == SKYBODY_THROTTLE) {
    id = kSetActuatorControlTarget;
    payload = actuators(c, micros);
  } else {
    id = kSetPositionTargetLocalNed;
    payload = position_target(c, millis);
  }
  append(payload, system);
  append(payload, component);
  if (id == kSetAttitudeTarget) {  // type_mask: the attitude, or the rates, do not count
    const bool has_rates = c.size() > 5;
    append(payload, static_cast<std::uint8_t>(signal_ == SKYBODY_CTBR ? 128 : has_rates ? 0 : 7));
  }
  if (id == kSetPositionTargetLocalNed) append(payload, kLocalNed);
  return framed(id, payload, sequence_++);
}

}  // namespace skybody::onboard::mavlink
