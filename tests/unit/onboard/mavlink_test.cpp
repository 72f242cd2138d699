// Frames and signs of MAVLink's messages, a test for each row of the table in docs/onboard.md. That
// numbers, sizes and checksums are MAVLink's is tested with pymavlink (tests/python).
#include "onboard/mavlink.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/unit/onboard/hover_mission.h"

namespace skybody::onboard::mavlink {
namespace {

constexpr double kFloat = 1e-6;  // rounding to float, of values of about 1
const double kHalf = std::sqrt(0.5);

/// A payload with floats from `offset` on.
class Payload {
 public:
  explicit Payload(std::size_t size) : bytes_(size, '\0') {}
  template <class T>
  Payload& put(std::size_t offset, std::initializer_list<double> values) {
    for (const double value : values) {
      const auto typed = static_cast<T>(value);
      std::memcpy(bytes_.data() + offset, &typed, sizeof typed);
      offset += sizeof typed;
    }
    return *this;
  }
  Payload& floats(std::size_t offset, std::initializer_list<double> values) {
    return put<float>(offset, values);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

Message parsed(const std::string& bytes) {
  Parser parser(bytes);
  const auto message = parser.next();
  EXPECT_TRUE(message.has_value());
  return message.value_or(Message{});
}

double real(const Message& m, std::size_t offset) {
  float value;
  std::memcpy(&value, m.payload + offset, sizeof value);
  return static_cast<double>(value);
}

void expect_near(const Vec3<double>& v, double x, double y, double z) {
  EXPECT_NEAR(v.x, x, kFloat);
  EXPECT_NEAR(v.y, y, kFloat);
  EXPECT_NEAR(v.z, z, kFloat);
}

class ReceiverTest : public testing::Test {
 protected:
  void take(std::uint32_t id, const Payload& payload, double now = 0.0) {
    const std::string bytes = framed(id, payload.bytes(), 0);
    receiver_.take(bytes, now);
  }
  Motion motion() { return pilot_.situation().body(0); }
  Mission mission_ = hover_mission();
  Pilot pilot_{mission_};
  Inbox inbox_{pilot_, {}, false, true};
  Receiver receiver_{inbox_};
};

/// A vehicle that looks to the east (yaw 90 degrees clockwise) and flies forward.
Payload odometry_to_the_east() {
  Payload p(233);
  p.put<std::uint64_t>(0, {2e6});
  p.floats(8, {1, 2, -3}).floats(20, {kHalf, 0, 0, kHalf}).floats(36, {4, 0, 0});
  return p.floats(48, {0.1, 0.2, 0.3}).put<std::uint8_t>(228, {1, 12});
}

TEST_F(ReceiverTest, OdometryIsNedAndItsVelocityForwardRightDown) {
  take(kOdometry, odometry_to_the_east());
  expect_near(motion().position, 1, -2, 3);
  expect_near(motion().velocity, 0, -4, 0);  // to the east: -y of W
  expect_near(motion().angular_velocity, 0.1, -0.2, -0.3);
  EXPECT_NEAR(motion().rotation.w, kHalf, kFloat);
  EXPECT_NEAR(motion().rotation.z, -kHalf, kFloat);
  EXPECT_DOUBLE_EQ(inbox_.stamp(), 2.0);
}

TEST_F(ReceiverTest, OdometryOfOtherFramesIsRefused) {
  Payload p = odometry_to_the_east();
  p.put<std::uint8_t>(228, {0, 12});  // global
  take(kOdometry, p);
  EXPECT_FALSE(inbox_.is_complete());
  EXPECT_EQ(inbox_.counts().all_refused(), 1u);
}

TEST_F(ReceiverTest, LocalPositionAndAttitudeMakeAPose) {
  take(kLocalPositionNed, Payload(28).floats(4, {1, 2, -3, 4, 5, -6}));
  EXPECT_FALSE(inbox_.is_complete());
  Payload attitude(48);
  attitude.put<std::uint32_t>(0, {1500}).floats(4, {kHalf, kHalf, 0, 0, 0.1, 0.2, 0.3});
  take(kAttitudeQuaternion, attitude, 0.05);
  expect_near(motion().position, 1, -2, 3);
  expect_near(motion().velocity, 4, -5, 6);
  expect_near(motion().angular_velocity, 0.1, -0.2, -0.3);
  EXPECT_NEAR(motion().rotation.x, kHalf, kFloat);  // right side down, in both
  EXPECT_DOUBLE_EQ(inbox_.stamp(), 1.5);
}

TEST_F(ReceiverTest, AnOldPositionMakesNoPose) {
  take(kLocalPositionNed, Payload(28).floats(4, {1, 2, -3}));
  take(kAttitudeQuaternion, Payload(32).floats(4, {1, 0, 0, 0}), 0.2);
  EXPECT_FALSE(inbox_.is_complete());
}

TEST_F(ReceiverTest, HighresImuIsForwardRightDown) {
  take(kHighresImu, Payload(63).floats(8, {1, 2, -9.8, 0.1, 0.2, 0.3}));  // at rest -9.8
  const std::vector<double>& v = pilot_.situation().sensors;
  expect_near({v[0], v[1], v[2]}, 1, -2, 9.8);
  expect_near({v[3], v[4], v[5]}, 0.1, -0.2, -0.3);
}

TEST_F(ReceiverTest, CommandsGoToTheSystemOfTheLastHeartbeat) {
  std::string bytes =
      framed(kHeartbeat, Payload(9).put<std::uint8_t>(4, {2, 12, 0, 4, 3}).bytes(), 0);
  receiver_.take(bytes, 0.0);
  EXPECT_EQ(receiver_.component(), 191);
}

TEST_F(ReceiverTest, DamagedAndCutMessagesAreRefused) {
  std::string bytes = framed(kOdometry, odometry_to_the_east().bytes(), 0);
  receiver_.take(std::span(bytes).first(bytes.size() - 1), 0.0);
  bytes[40] = static_cast<char>(bytes[40] ^ 1);
  receiver_.take(bytes, 0.0);
  EXPECT_FALSE(inbox_.is_complete());
  EXPECT_EQ(inbox_.counts().all_refused(), 2u);
}

Message sent(int signal, std::initializer_list<double> command) {
  const Mission mission = hover_mission(signal);
  Sender sender(mission);
  const std::vector<double> values(command);
  return parsed(sender.command({Mode::kPolicy, 0, {}, values}, 1.5, 7, 3));
}

TEST(Sender, CtbrIsAnAttitudeTargetWithRatesAndAShareOfTheThrust) {
  const Message m = sent(SKYBODY_CTBR, {0.25 * kMostThrust, 0.1, 0.2, 0.3});
  EXPECT_EQ(m.id, kSetAttitudeTarget);
  EXPECT_NEAR(real(m, 20), 0.1, kFloat);
  EXPECT_NEAR(real(m, 24), -0.2, kFloat);
  EXPECT_NEAR(real(m, 28), -0.3, kFloat);
  EXPECT_NEAR(real(m, 32), 0.25, kFloat);
  EXPECT_EQ(m.payload[36], 7);
  EXPECT_EQ(m.payload[37], 3);
  EXPECT_EQ(m.payload[38], 128);  // the attitude does not count
}

TEST(Sender, ForceIsInNedAndYawClockwise) {
  const Message m = sent(SKYBODY_FORCE, {1, 2, 9, 0.4});
  EXPECT_EQ(m.id, kSetPositionTargetLocalNed);
  EXPECT_NEAR(real(m, 28), 1, kFloat);
  EXPECT_NEAR(real(m, 32), -2, kFloat);
  EXPECT_NEAR(real(m, 36), -9, kFloat);
  EXPECT_NEAR(real(m, 40), -0.4, kFloat);
  EXPECT_EQ(m.payload[48] | m.payload[49] << 8, 7 | 56 | 512 | 2048);
  EXPECT_EQ(m.payload[52], 1);  // MAV_FRAME_LOCAL_NED
}

TEST(Sender, AVelocityHasAYawRate) {
  const Message m = sent(SKYBODY_VELOCITY_TRACKING, {1, 2, 3, 0.4});
  EXPECT_NEAR(real(m, 16), 1, kFloat);
  EXPECT_NEAR(real(m, 20), -2, kFloat);
  EXPECT_NEAR(real(m, 24), -3, kFloat);
  EXPECT_NEAR(real(m, 44), -0.4, kFloat);
  EXPECT_EQ(m.payload[48] | m.payload[49] << 8, 7 | 448 | 1024);
}

TEST(Sender, APositionHasAYaw) {
  const Message m = sent(SKYBODY_POSITION, {1, 2, 3, 0.4});
  EXPECT_NEAR(real(m, 8), -2, kFloat);
  EXPECT_NEAR(real(m, 40), -0.4, kFloat);
  EXPECT_EQ(m.payload[48] | m.payload[49] << 8, 56 | 448 | 2048);
}

TEST(Sender, RotorsAreSharesOfTheirLargestSpeed) {
  const Message speeds = sent(SKYBODY_ROTOR_SPEED, {0, 250, 500, 1000});
  EXPECT_EQ(speeds.id, kSetActuatorControlTarget);
  EXPECT_NEAR(real(speeds, 12), 0.25, kFloat);
  EXPECT_NEAR(real(speeds, 20), 1.0, kFloat);
  const Message thrusts = sent(SKYBODY_SRT, {0, 0.25 * kMostThrust / 4, 0, 0});
  EXPECT_NEAR(real(thrusts, 12), 0.5, kFloat);  // of the speed: the square root
}

TEST(Sender, RefusesCommandsThatNoMessageCarries) {
  const Mission mission = hover_mission(SKYBODY_CTBT);
  EXPECT_THROW(Sender{mission}, Error);
}

}  // namespace
}  // namespace skybody::onboard::mavlink
