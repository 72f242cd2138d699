// Odometry and wrenches over Gazebo Transport, for Python's ctypes.
#include <ignition/msgs/odometry.pb.h>
#include <ignition/msgs/wrench.pb.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <ignition/transport/Node.hh>
#include <string>

namespace {

ignition::transport::Node& node() {
  static ignition::transport::Node made;
  return made;
}

/// time [s], position, rotation w x y z, velocity, rates.
constexpr int kOdometry = 14;

void set(ignition::msgs::Vector3d& to, const double* values) {
  to.set_x(values[0]);
  to.set_y(values[1]);
  to.set_z(values[2]);
}

void get(const ignition::msgs::Vector3d& from, double* values) {
  values[0] = from.x();
  values[1] = from.y();
  values[2] = from.z();
}

}  // namespace

extern "C" {

/// Publisher of a topic; wrenches if is_wrench, else odometry.
void* sync_publisher(const char* topic, bool is_wrench) {
  auto made = is_wrench ? node().Advertise<ignition::msgs::Wrench>(topic)
                        : node().Advertise<ignition::msgs::Odometry>(topic);
  return made ? new ignition::transport::Node::Publisher(made) : nullptr;
}

/// Sends 6 numbers under a word.
void sync_send_wrench(void* publisher, const char* word, const double* values) {
  ignition::msgs::Wrench message;
  auto* entry = message.mutable_header()->add_data();
  entry->set_key("frame_id");
  entry->add_value(word);
  set(*message.mutable_force(), values);
  set(*message.mutable_torque(), values + 3);
  static_cast<ignition::transport::Node::Publisher*>(publisher)->Publish(message);
}

/// Sends the kOdometry numbers.
void sync_send_odometry(void* publisher, const double* values) {
  ignition::msgs::Odometry message;
  const auto time = static_cast<std::int64_t>(std::llround(values[0] * 1e9));
  message.mutable_header()->mutable_stamp()->set_sec(time / 1000000000);
  message.mutable_header()->mutable_stamp()->set_nsec(static_cast<int>(time % 1000000000));
  set(*message.mutable_pose()->mutable_position(), values + 1);
  auto* rotation = message.mutable_pose()->mutable_orientation();
  rotation->set_w(values[4]);
  rotation->set_x(values[5]);
  rotation->set_y(values[6]);
  rotation->set_z(values[7]);
  set(*message.mutable_twist()->mutable_linear(), values + 8);
  set(*message.mutable_twist()->mutable_angular(), values + 11);
  static_cast<ignition::transport::Node::Publisher*>(publisher)->Publish(message);
}

/// Calls `act` with the word and the 6 numbers of each wrench, in a thread of the library.
bool sync_take_wrenches(const char* topic, void (*act)(const char*, const double*)) {
  std::function<void(const ignition::msgs::Wrench&)> take =
      [act](const ignition::msgs::Wrench& message) {
        double values[6];
        get(message.force(), values);
        get(message.torque(), values + 3);
        act(message.header().data(0).value(0).c_str(), values);
      };
  return node().Subscribe(topic, take);
}

/// Calls `act` with the kOdometry numbers of each message, in a thread of the library.
bool sync_take_odometry(const char* topic, void (*act)(const double*)) {
  std::function<void(const ignition::msgs::Odometry&)> take =
      [act](const ignition::msgs::Odometry& message) {
        double values[kOdometry];
        const auto& stamp = message.header().stamp();
        values[0] = static_cast<double>(stamp.sec()) + 1e-9 * stamp.nsec();
        get(message.pose().position(), values + 1);
        const auto& rotation = message.pose().orientation();
        values[4] = rotation.w();
        values[5] = rotation.x();
        values[6] = rotation.y();
        values[7] = rotation.z();
        get(message.twist().linear(), values + 8);
        get(message.twist().angular(), values + 11);
        act(values);
      };
  return node().Subscribe(topic, take);
}
}
