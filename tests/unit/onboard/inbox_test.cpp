#include "onboard/inbox.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "onboard/mavlink.h"
#include "onboard/packets.h"
#include "tests/unit/onboard/hover_mission.h"

namespace skybody::onboard {
namespace {

template <class Packet>
Packet packet_of(PacketType type, double stamp) {
  Packet packet{};
  std::memcpy(packet.header.magic, kPacketMagic, sizeof kPacketMagic);
  packet.header.version = kPacketVersion;
  packet.header.type = static_cast<std::uint8_t>(type);
  packet.header.size = sizeof packet;
  packet.header.stamp = stamp;
  return packet;
}

StatePacket state_at(double stamp, double height) {
  auto packet = packet_of<StatePacket>(PacketType::kState, stamp);
  packet.body = -1;
  packet.values[2] = height;
  packet.values[3] = 1.0;
  return packet;
}

template <class Packet>
std::span<const char> bytes_of(const Packet& packet) {
  return {reinterpret_cast<const char*>(&packet), sizeof packet};
}

class InboxTest : public testing::Test {
 protected:
  std::uint64_t refused(Refusal why) const {
    return inbox_.counts().refused[static_cast<std::size_t>(why)];
  }
  double height() { return pilot_.situation().body(0).position.z; }
  template <class Packet>
  void take(const Packet& packet, double now = 0.0) {
    inbox_.take(bytes_of(packet), now);
  }
  Mission mission_ = hover_mission();
  Pilot pilot_{mission_};
  Inbox inbox_{pilot_, {}, false, true};
};

TEST_F(InboxTest, TakesAPoseAndLetsThePolicyFly) {
  EXPECT_FALSE(inbox_.is_complete());
  take(state_at(1.0, 1.5), 10.0);
  EXPECT_EQ(height(), 1.5);
  EXPECT_EQ(inbox_.age(10.25), 0.25);
  inbox_.engage_if_wanted();
  EXPECT_EQ(pilot_.mode(), Mode::kPolicy);
}

TEST_F(InboxTest, RefusesWhatIsCutForeignLateOrNoNumber) {
  take(state_at(1.0, 1.5));
  const StatePacket good = state_at(2.0, 9.0);
  inbox_.take(bytes_of(good).first(100), 0.0);
  inbox_.take(bytes_of(good).first(3), 0.0);
  EXPECT_EQ(refused(Refusal::kShort), 2u);
  StatePacket bad = good;
  bad.header.magic[0] = 'X';
  take(bad);
  bad = good;
  bad.header.version = 9;
  take(bad);
  EXPECT_EQ(refused(Refusal::kForeign), 2u);
  take(state_at(0.5, 9.0));
  take(state_at(1.0, 9.0));
  EXPECT_EQ(refused(Refusal::kLate), 2u);
  bad = good;
  bad.values[7] = std::numeric_limits<double>::quiet_NaN();
  take(bad);
  bad = good;
  bad.values[3] = 0.5;  // no unit quaternion
  take(bad);
  EXPECT_EQ(refused(Refusal::kBad), 2u);
  bad = good;
  bad.body = 7;
  take(bad);
  EXPECT_EQ(refused(Refusal::kUnknown), 1u);
  EXPECT_EQ(height(), 1.5);
}

TEST_F(InboxTest, ASendersClockMayBeginAnewAfterASilence) {
  take(state_at(100.0, 1.0), 0.0);
  take(state_at(1.0, 2.0), 0.5);
  EXPECT_EQ(height(), 1.0);
  take(state_at(1.0, 3.0), 2.0);
  EXPECT_EQ(height(), 3.0);
}

TEST_F(InboxTest, SetsTheTargetByItsPath) {
  auto packet = packet_of<ParamPacket>(PacketType::kParam, 0.0);
  std::strcpy(packet.path, "task.target");
  packet.count = 4;
  packet.values[2] = 2.5;
  take(packet);
  EXPECT_EQ(pilot_.situation().params[2], 2.5);
  std::strcpy(packet.path, "task.nothing");
  take(packet);
  EXPECT_EQ(refused(Refusal::kUnknown), 1u);
}

TEST_F(InboxTest, ControlSwitchesOffAndOnWithTheNextPose) {
  take(state_at(1.0, 1.0));
  inbox_.engage_if_wanted();
  auto packet = packet_of<ControlPacket>(PacketType::kControl, 0.0);
  take(packet);
  EXPECT_EQ(pilot_.mode(), Mode::kSafe);
  packet.engage = 1;
  take(packet);
  inbox_.engage_if_wanted();
  EXPECT_EQ(pilot_.mode(), Mode::kSafe);
  take(state_at(0.5, 1.0));
  inbox_.engage_if_wanted();
  EXPECT_EQ(pilot_.mode(), Mode::kPolicy);
}

/// Random changes of good packets; also of their headers' magic, which is then put right again for
/// half of them, so that the content is read.
TEST_F(InboxTest, AHundredThousandSpoiledPacketsLeaveOnlyFinitePoses) {
  std::mt19937 draw(7);
  testing::internal::CaptureStderr();
  mavlink::Receiver receiver(inbox_);
  for (int k = 0; k < 100'000; ++k) {
    StatePacket packet = state_at(k, 1.0);
    const PacketType types[] = {PacketType::kState, PacketType::kImu, PacketType::kParam,
                                PacketType::kControl, PacketType::kCommand};
    packet.header.type = static_cast<std::uint8_t>(types[draw() % 5]);
    auto* bytes = reinterpret_cast<unsigned char*>(&packet);
    for (std::uint32_t n = draw() % 6; n > 0; --n) {
      bytes[draw() % sizeof packet] = static_cast<unsigned char>(draw());
    }
    const std::size_t size = draw() % 4 == 0 ? draw() % sizeof packet : sizeof packet;
    if (draw() % 2 == 0) bytes[0] = draw() % 2 == 0 ? 0xfd : 0xfe;
    receiver.take(bytes_of(packet).first(size), 0.01 * k);
    inbox_.take(bytes_of(packet).first(size), 0.01 * k);
    inbox_.engage_if_wanted();
    const Decision decision = pilot_.step({0.01 * k, 0.0, 0.0, 1});
    for (const double value : decision.command) ASSERT_TRUE(std::isfinite(value)) << k;
    ASSERT_TRUE(pilot_.situation().body(0).is_valid()) << k;
  }
  const std::string messages = testing::internal::GetCapturedStderr();
  EXPECT_LT(std::count(messages.begin(), messages.end(), '\n'), 10);
  EXPECT_GT(inbox_.counts().taken, 1000u);
  EXPECT_GT(inbox_.counts().all_refused(), 1000u);
}

TEST(CommandPacket, HasActionsThenCommandsAtMultiplesOfEight) {
  const float action[] = {0.5f, -0.5f, 0.25f};
  const double command[] = {1.0, 2.0};
  char packet[kLargestPacket];
  const std::size_t size =
      write_command({Mode::kPolicy, 0, action, command}, SKYBODY_CTBR, 3.5, 9, packet);
  EXPECT_EQ(size, 40u + 16u + 16u);
  double second = 0.0;
  std::memcpy(&second, packet + 40 + 16 + 8, sizeof second);
  EXPECT_EQ(second, 2.0);
  EXPECT_EQ(write_command({Mode::kPolicy, 0, action, command}, SKYBODY_CTBR, 3.5, 9,
                          std::span(packet, 40)),
            0u);
}

}  // namespace
}  // namespace skybody::onboard
