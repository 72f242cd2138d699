// Stubs of PX4's interfaces that examples/deploy/px4 uses: the same names and types, of our own.
// Topics live in one place each; fly.cpp fills and reads them.
#pragma once

#include <cstdint>
#include <cstdio>

#define MODULE_NAME "skybody_policy"
#define __EXPORT
#define PX4_OK 0
#define PX4_ERROR (-1)
#define PX4_INFO(...) ((void)std::fprintf(stderr, __VA_ARGS__), (void)std::fputc('\n', stderr))
#define PX4_WARN PX4_INFO
#define PX4_ERR PX4_INFO
#define PRINT_MODULE_DESCRIPTION(TEXT) ((void)0)
#define PRINT_MODULE_USAGE_NAME(NAME, CATEGORY) ((void)0)
#define PRINT_MODULE_USAGE_COMMAND(NAME) ((void)0)
#define PRINT_MODULE_USAGE_DEFAULT_COMMANDS() ((void)0)

using hrt_abstime = std::uint64_t;
extern hrt_abstime stub_now;
inline hrt_abstime hrt_absolute_time() { return stub_now; }

struct vehicle_angular_velocity_s {
  std::uint64_t timestamp;
  float xyz[3];
};
struct vehicle_attitude_s {
  std::uint64_t timestamp;
  float q[4];
};
struct vehicle_local_position_s {
  std::uint64_t timestamp;
  bool xy_valid, z_valid;
  float x, y, z, vx, vy, vz, heading;
};
struct trajectory_setpoint_s {
  std::uint64_t timestamp;
  float position[3];
  float yaw;
};
struct vehicle_status_s {
  static constexpr std::uint8_t ARMING_STATE_ARMED = 2, NAVIGATION_STATE_OFFBOARD = 14;
  std::uint64_t timestamp;
  std::uint8_t arming_state, nav_state;
};
struct offboard_control_mode_s {
  std::uint64_t timestamp;
  bool position, velocity, acceleration, attitude, body_rate;
};
struct vehicle_rates_setpoint_s {
  std::uint64_t timestamp;
  float roll, pitch, yaw, thrust_body[3];
};

template <class Message>
struct StubTopic {
  Message message{};
  int published = 0;
};
#define STUB_TOPIC(NAME) inline StubTopic<NAME##_s> stub_##NAME;
STUB_TOPIC(vehicle_angular_velocity)
STUB_TOPIC(vehicle_attitude)
STUB_TOPIC(vehicle_local_position)
STUB_TOPIC(trajectory_setpoint)
STUB_TOPIC(vehicle_status)
STUB_TOPIC(offboard_control_mode)
STUB_TOPIC(vehicle_rates_setpoint)
#define ORB_ID(NAME) (&stub_##NAME)

namespace uORB {
class Subscription {
 public:
  template <class Message>
  explicit Subscription(StubTopic<Message> *topic) : topic_(topic) {}
  template <class Message>
  bool update(Message *message) {
    *message = static_cast<StubTopic<Message> *>(topic_)->message;
    return true;
  }

 private:
  void *topic_;
};
template <class Message>
class Publication {
 public:
  explicit Publication(StubTopic<Message> *topic) : topic_(topic) {}
  bool publish(const Message &message) {
    topic_->message = message;
    ++topic_->published;
    return true;
  }

 private:
  StubTopic<Message> *topic_;
};
}  // namespace uORB

namespace px4 {
struct wq_config_t {};
namespace wq_configurations {
inline wq_config_t nav_and_controllers;
}
class ScheduledWorkItem {
 public:
  ScheduledWorkItem(const char *, const wq_config_t &) {}
  virtual ~ScheduledWorkItem() = default;
  void ScheduleOnInterval(std::uint32_t period) { stub_period = period; }
  void ScheduleClear() { stub_period = 0; }
  void stub_run() { Run(); }
  std::uint32_t stub_period = 0;

 protected:
  virtual void Run() = 0;
};
}  // namespace px4

template <class Module>
class ModuleBase {
 public:
  virtual ~ModuleBase() = default;
  virtual int print_status() { return 0; }
  static int main(int argc, char *argv[]) { return Module::task_spawn(argc, argv); }
  static Module *get_instance() { return _object.object; }

 protected:
  struct Atomic {
    Module *object = nullptr;
    void store(Module *one) { object = one; }
  };
  bool should_exit() const { return false; }
  void exit_and_cleanup() {}
  static constexpr int task_id_is_work_queue = -2;
  static inline Atomic _object;
  static inline int _task_id = -1;
};
