// Joint stops in a physics step of the environments of one Real.
#pragma once

#include "core/physics/step/step_arrays.h"

namespace skybody {

/// Applies JointStops to the coordinates of a step, or to its accelerations.
template <class Real, class Values>
class StopCorrection {
 public:
  /// @param arrays  coordinates of the step, in `now`
  SKYBODY_INLINE StopCorrection(const StepPlan& plan, const Values& params, const Values& derived,
                                const StepArrays<Real>& arrays)
      : plan_(plan), params_(params), derived_(derived), a_(arrays) {}

  /// Corrects the step's end for stops.
  SKYBODY_INLINE void correct_end(const MaskOf<Real>& mask) const {
    push_at_stops(mask, a_.now,
                  [&](const RobotLayout& robot, const MaskOf<Real>& where, const Real* change)
                      SKYBODY_INLINE_LAMBDA {
                        Real* const step = a_.stages.rate.u;
                        for (int k = robot.first_u; k < robot.first_u + robot.u_count; ++k) {
                          step[k] = select(where, dt() * change[k], Real(0.0));
                          a_.now.u[k] = select(where, a_.now.u[k] + step[k], a_.now.u[k]);
                        }
                        move_on(robot, where, step);
                      });
  }

  /// Adds the accelerations by stops over the coming step.
  SKYBODY_INLINE void add_accelerations(Real* udot) const {
    const Coordinates<Real>& end = a_.stages.point;
    for (const TreeBody& body : tree()) {
      if (body.type != JointType::kPin && body.type != JointType::kSlider) continue;
      end.u[body.u] = a_.now.u[body.u] + dt() * udot[body.u];
      end.q[body.q] = a_.now.q[body.q] + (0.5 * dt()) * (a_.now.u[body.u] + end.u[body.u]);
    }
    push_at_stops(MaskOf<Real>(true), end,
                  [&](const RobotLayout& robot, const MaskOf<Real>& where, const Real* change)
                      SKYBODY_INLINE_LAMBDA {
                        for (int k = robot.first_u; k < robot.first_u + robot.u_count; ++k) {
                          udot[k] += select(where, change[k], Real(0.0));
                        }
                      });
  }

 private:
  double dt() const { return plan_.world.scenario.stepping.dt; }
  const std::vector<TreeBody>& tree() const { return plan_.multibody.bodies(); }

  /// Calls f(robot, where, change) for robots at stops: see JointStops::act.
  /// @param end  the end of the step without stops
  template <class F>
  SKYBODY_INLINE void push_at_stops(const MaskOf<Real>& mask, const Coordinates<Real>& end,
                                    const F& f) const {
    plan_.stops.act(plan_.multibody, params_, derived_ + plan_.derived.bodies, dt(), mask, a_.now.q,
                    end.q, end.u, a_.multibody, a_.stops, f);
  }

  /// Moves the coordinates of a robot for dt at rates `u`.
  SKYBODY_INLINE void move_on(const RobotLayout& robot, const MaskOf<Real>& where,
                              const Real* u) const {
    for (int i = robot.first_body; i < robot.first_body + robot.body_count; ++i) {
      const TreeBody& body = tree()[static_cast<std::size_t>(i)];
      Real moved[7];
      const int count = position_size(body.type);
      for (int k = 0; k < count; ++k) moved[k] = a_.now.q[body.q + k];
      drift_position(body.type, dt(), u + body.u, moved);
      normalize_position(body.type, moved);
      for (int k = 0; k < count; ++k) {
        a_.now.q[body.q + k] = select(where, moved[k], a_.now.q[body.q + k]);
      }
    }
  }

  const StepPlan& plan_;
  const Values &params_, &derived_;
  const StepArrays<Real>& a_;
};

}  // namespace skybody
