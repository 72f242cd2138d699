// Parts of the observation of one robot: its own values, the usual ones of its base, and its
// action.
#pragma once

#include <skybody/plugin.h>

#include <string>
#include <utility>

#include "plugins/task_kit/attitude.h"
#include "plugins/task_kit/parts.h"
#include "plugins/task_kit/spawn.h"

namespace skybody::task_kit {

/// Declares parts of one robot's observation.
class RobotParts {
 public:
  /// @param robot   the owner's index
  /// @param prefix  of the parts' names: a team's robots have their name and a dot
  RobotParts(const Setup& setup, ObservationParts& parts, int robot, std::string prefix = "")
      : setup_(setup), parts_(parts), robot_(robot), prefix_(std::move(prefix)) {}

  /// Declares the next part. @param low, high  bounds of its values
  Part operator()(const std::string& name, const char* unit, int count, const std::string& doc,
                  double low, double high) const {
    return parts_.add(setup_, {prefix_ + name, unit, count, doc, low, high, robot_});
  }
  /// The same with values between -bound and bound.
  Part operator()(const std::string& name, const char* unit, int count, const std::string& doc,
                  double bound = kInfinity) const {
    return (*this)(name, unit, count, doc, -bound, bound);
  }

 private:
  const Setup& setup_;
  ObservationParts& parts_;
  int robot_;
  std::string prefix_;
};

/// Observed motion of a robot's base: `velocity`, `attitude` and `angular_velocity`.
struct MotionParts {
  Part velocity = {};          ///< of the base's frame, W [m/s]
  Part attitude = {};          ///< quaternion w x y z, W from B, w >= 0
  Part angular_velocity = {};  ///< B [rad/s]

  /// Declares the parts in this order.
  void declare(const RobotParts& part) {
    velocity = part("velocity", "m/s", 3, "velocity of the base's frame, W");
    attitude = part("attitude", "", 4, "quaternion w x y z, W from B, with w >= 0", 1.0);
    angular_velocity = part("angular_velocity", "rad/s", 3, "angular velocity of the base, B");
  }
  /// Writes them.
  template <class Real>
  SKYBODY_INLINE void set(const Values<Real>& row, const BodyMotion<Real>& body) const {
    velocity.set(row, body.velocity);
    attitude.set(row, canonical(body.rotation));
    angular_velocity.set(row, body.angular_velocity);
  }
};

/// A robot's action of the present step, and its part `action` of the observation.
class ActionPart {
 public:
  ActionPart() = default;
  /// @param task  the task's name, for the message
  /// @throws std::runtime_error if the robot takes no action
  ActionPart(const RobotInfo& robot, const std::string& task)
      : first_(robot.first_action), count_(action_count(robot, task)) {}

  int count() const { return count_; }  ///< number of values

  /// Value k of the action, in [-1, 1].
  template <class Real>
  SKYBODY_INLINE Real value(const EnvView<Real>& env, int k) const {
    return env.action(first_ + k);
  }
  /// Declares the part.
  void declare(const RobotParts& part) {
    part_ = part("action", "", count_, "action of this step, in [-1, 1]; -1 at a reset", 1.0);
  }
  /// Writes the part.
  template <class Real>
  SKYBODY_INLINE void set(const EnvView<Real>& env, const Values<Real>& row) const {
    const auto stepped = env.step() > Word<Real>(0);
    for (int k = 0; k < count_; ++k) {
      part_.set(row, select(stepped, value(env, k), Real(-1.0)), k);
    }
  }

 private:
  int first_ = 0, count_ = 0;
  Part part_;
};

/// The one robot of a task, and its parameter `robot`. Make it a member of the task, among its
/// parameters.
class OneRobot {
 public:
  explicit OneRobot(Plugin* owner)
      : name_(owner, word("robot", "", "name of the robot; optional for a single robot")) {}

  /// Finds the robot. @param task  the task's name, for the message
  /// @throws std::runtime_error if there is no such robot, or it takes no action
  const RobotInfo& configure(const Setup& setup, const std::string& task) {
    index_ = setup.robot(name_.value());
    const RobotInfo& info = setup.robots()[index_];
    body_ = info.first_body;
    action = ActionPart(info, task);
    return info;
  }

  int index() const { return index_; }  ///< of the robot
  int body() const { return body_; }    ///< world index of its base

  ActionPart action;  ///< its action

 private:
  TextParameter name_;
  int index_ = 0, body_ = 0;
};

/// A point that is fixed to a body, such as a link's centre of mass.
struct BodyPoint {
  int body = 0;             ///< world index
  Vec3<double> point = {};  ///< in the body's frame [m]

  /// The same in every lane.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> lever() const {
    return {Real(point.x), Real(point.y), Real(point.z)};
  }
  /// The motion of a frame at the point, with the body's axes.
  template <class Real>
  SKYBODY_INLINE BodyMotion<Real> at(BodyMotion<Real> motion) const {
    motion.position = motion.position + rotate(motion.rotation, lever<Real>());
    motion.velocity =
        motion.velocity + rotate(motion.rotation, cross(motion.angular_velocity, lever<Real>()));
    return motion;
  }
};

}  // namespace skybody::task_kit
