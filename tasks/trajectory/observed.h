// Observation of the task `trajectory`: a history of the flight, and a window of the path ahead.
#pragma once

#include <skybody/task_kit.h>

#include <string>

namespace skybody::tracking {

using namespace task_kit;

/// The observed motion of the robot.
template <class Real>
struct Flight {
  BodyMotion<Real> body;
  Quat<Real> axes;  ///< W from the axes of the observed vectors
  SKYBODY_INLINE Vec3<Real> seen(const Vec3<Real>& v) const { return rotate_inverse(axes, v); }
};

/// The reference at one moment of the window.
template <class Real>
struct Ahead {
  Vec3<Real> position, velocity;  ///< W [m], [m/s]
  Quat<Real> rotation;            ///< W from B, of a vehicle on the path
};

/// Parts of the observation, and the histories behind them.
class Observed {
 public:
  struct Choice {
    int history, window;  ///< number of past entries, and of moments ahead
    bool matrices;        ///< with the rotation of each entry and moment; false: only the present
                          ///< one
    bool body_axes;       ///< vectors in B instead of W
    bool past_actions;    ///< the history contains the actions
    int robot, actions;
  };

  /// Declares the parts in the order of the observation.
  void configure(const Setup& setup, const Choice& choice) {
    choice_ = choice;
    const std::string axes = choice.body_axes ? "B" : "W";
    const std::string past = ", for each step of the history, newest first";
    const std::string ahead = ", for each moment of the window, the present one first";
    const int h = choice.history, f = choice.window, m = choice.actions;
    height_ = add(setup, "height", "m", h, "height of the base" + past);
    velocity_ =
        add(setup, "velocity", "m/s", 3 * h, "velocity of the base's frame, " + axes + past);
    if (choice.matrices) {
      attitude_ =
          add(setup, "attitude", "", 9 * h, "rotation matrix W from B, row by row" + past, 1.0);
    }
    rates_ =
        add(setup, "angular_velocity", "rad/s", 3 * h, "angular velocity of the base, B" + past);
    if (choice.past_actions) {
      actions_ = add(setup, "actions", "", m * h, "actions in [-1, 1]; -1 at a reset" + past, 1.0);
    }
    position_error_ = add(setup, "position_error", "m", 3 * f,
                          "reference position - present position, " + axes + ahead);
    velocity_error_ = add(setup, "velocity_error", "m/s", 3 * f,
                          "reference velocity - present velocity, " + axes + ahead);
    if (choice.matrices) {
      reference_attitude_ = add(setup, "reference_attitude", "", 9 * f,
                                "rotation matrix W from B, row by row" + ahead, 1.0);
    } else {
      attitude_ = choice.body_axes
                      ? add(setup, "up", "", 3, "z axis of W, B", 1.0)
                      : add(setup, "attitude", "", 4, "quaternion w x y z, W from B, w >= 0", 1.0);
      yaw_error_ =
          add(setup, "yaw_error", "rad", 1, "path's yaw - own yaw, wrapped to [-pi, pi]", kPi);
    }
    heights_ = History(memory_, h, 1);
    velocities_ = History(memory_, h, 3);
    if (choice.matrices) attitudes_ = History(memory_, h, 9);
    all_rates_ = History(memory_, h, 3);
    if (choice.past_actions) all_actions_ = History(memory_, h, m);
    setup.buffer(memory_.size());
  }
  int window() const { return choice_.window; }
  bool has_matrices() const { return choice_.matrices; }

  template <class Real>
  SKYBODY_INLINE Flight<Real> flight(const BodyMotion<Real>& body) const {
    return {body, choice_.body_axes ? body.rotation : Quat<Real>::identity()};
  }

  /// Adds this moment to the histories, and writes them.
  /// @param action  action(k): value k of this step's action
  template <class Real, class Action>
  SKYBODY_INLINE void past(const EnvView<Real>& env, const Flight<Real>& flight,
                           const Action& action, const Values<Real>& buffer,
                           const Values<Real>& row) const {
    const BodyMotion<Real>& body = flight.body;
    const Vec3<Real> velocity = flight.seen(body.velocity);
    const auto stepped = env.step() > Word<Real>(0);
    heights_.note(env, buffer, [&](int) { return body.position.z; });
    velocities_.note(env, buffer, [&](int k) { return component(velocity, k); });
    all_rates_.note(env, buffer, [&](int k) { return component(body.angular_velocity, k); });
    all_actions_.note(env, buffer, [&](int k) { return select(stepped, action(k), Real(-1.0)); });
    heights_.observe(buffer, height_, row);
    velocities_.observe(buffer, velocity_, row);
    all_rates_.observe(buffer, rates_, row);
    all_actions_.observe(buffer, actions_, row);
    if (choice_.matrices) {
      const Mat3<Real> rotation = to_mat3(body.rotation);
      attitudes_.note(env, buffer, [&](int k) { return rotation(k / 3, k % 3); });
      attitudes_.observe(buffer, attitude_, row);
    }
  }

  /// Writes moment i of the window.
  template <class Real>
  SKYBODY_INLINE void ahead(int i, const Flight<Real>& flight, const Ahead<Real>& reference,
                            const Values<Real>& row) const {
    position_error_.set(row, flight.seen(reference.position - flight.body.position), 3 * i);
    velocity_error_.set(row, flight.seen(reference.velocity - flight.body.velocity), 3 * i);
    if (choice_.matrices) reference_attitude_.set(row, to_mat3(reference.rotation), 9 * i);
  }

  /// Writes the replacement of the matrices if there are none.
  template <class Real>
  SKYBODY_INLINE void present(const Flight<Real>& flight, const Real& yaw_error,
                              const Values<Real>& row) const {
    if (choice_.matrices) return;
    const Quat<Real>& q = flight.body.rotation;
    if (choice_.body_axes) {
      attitude_.set(row, rotate_inverse(q, Vec3<Real>{Real(0.0), Real(0.0), Real(1.0)}));
    } else {
      attitude_.set(row, canonical(q));
    }
    yaw_error_.set(row, yaw_error);
  }

 private:
  Part add(const Setup& setup, const char* name, const char* unit, int count,
           const std::string& doc, double bound = kInfinity) {
    return parts_.add(setup, {name, unit, count, doc, -bound, bound, choice_.robot});
  }
  template <class Real>
  static SKYBODY_INLINE Real component(const Vec3<Real>& v, int k) {
    return k == 0 ? v.x : k == 1 ? v.y : v.z;
  }

  Choice choice_{};
  ObservationParts parts_;
  BufferPlan memory_;
  Part height_, velocity_, attitude_, rates_, actions_;
  Part position_error_, velocity_error_, reference_attitude_, yaw_error_;
  History heights_, velocities_, attitudes_, all_rates_, all_actions_;
};

}  // namespace skybody::tracking
