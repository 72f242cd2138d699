// Nonlinear model-predictive control of single rotor thrusts along a trajectory.
#include <stdexcept>
#include <string>
#include <vector>

#include "controllers/common/measured_motion.h"
#include "controllers/common/trajectory.h"
#include "controllers/nmpc/solver.h"
#include "controllers/nmpc/vehicle.h"

namespace skybody {
namespace {

using nmpc::kMostInputs;
using nmpc::kMostNodes;

/// Layout of the buffer: these words in this order, then the inputs.
enum Word : int {
  kSolves = 0,        ///< iterations since the reset
  kFailures = 1,      ///< number of iterations that kept the last inputs
  kFailed = 2,        ///< 1: the latest iteration kept the last inputs
  kIterations = 3,    ///< active-set changes in the latest iteration
  kSaturated = 4,     ///< rotors at a limit in the latest iteration
  kAcceleration = 5,  ///< disturbance, W [m/s^2]
  kAngular = 8,       ///< disturbance, B [rad/s^2]
  kVelocity = 11,     ///< at the last call, W [m/s]
  kRotation = 14,     ///< at the last call
  kRates = 18,        ///< at the last call, B [rad/s]
  kShares = 21,       ///< at the last call, one per rotor
};

class Nmpc : public Controller {
 public:
  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    const auto nodes = static_cast<int>(horizon_.value());
    base_ = control::base_of(setup, robot);
    nmpc::set_vehicle(setup, robot, guide_);
    first_rotor_ = setup.robots()[robot].first_rotor;
    const int rotors = guide_.model.rotors;
    if (nodes * rotors > kMostInputs) {
      refuse("`horizon` ", nodes, " times ", rotors, " rotors are ", nodes * rotors,
             " inputs; allowed: up to ", kMostInputs, ": shorten it to ", kMostInputs / rotors);
    }
    for (const RotorInfo& rotor : setup.rotors_of(robot)) {
      rotors_.push_back(
          {control::full_thrust(rotor), rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT]});
    }
    measured_.configure(setup);
    set_times(setup);
    set_weights();
    declare(setup, nodes, rotors);
  }

  void control(const EnvView<double>& env, State<double>&, ConstValues<double> input,
               Values<double> output, Values<double> buffer) const {
    iterate(env, input, output, buffer);
  }

 private:
  struct RotorScale {
    double full;      ///< [N]
    double constant;  ///< k_f [N s^2]
  };

  /// Not inlined into the kernels, so that it is compiled once for the baseline, like the solver.
  [[gnu::noinline]] void iterate(const EnvView<double>& env, const ConstValues<double>& input,
                                 const Values<double>& output, const Values<double>& buffer) const {
    const nmpc::Motion now = motion_of(env);
    nmpc::Disturbance disturbance{buffer.vec3(kAcceleration), buffer.vec3(kAngular)};
    double inputs[kMostInputs];
    load_inputs(buffer, inputs);
    const bool is_first = buffer[kSolves] == 0.0;
    if (!is_first) {
      nmpc::Observed observed = nmpc::observe(guide_, remembered(buffer), inputs, now);
      if (measured_.is_by_imu()) {
        const Vec3<double> force = measured_.specific_force(env);
        observed.acceleration = nmpc::observe_force(guide_.model, now, force);
      }
      nmpc::follow(guide_, observed, disturbance);
      nmpc::shift(guide_, inputs);
    }
    nmpc::Target targets[kMostNodes + 1];
    set_targets(input, disturbance, targets);
    if (is_first || buffer[kFailed] != 0.0) begin(targets, inputs);
    const nmpc::QpResult result = nmpc::improve(guide_, now, disturbance, targets, inputs);
    store(buffer, now, disturbance, inputs, result);
    for (int r = 0; r < guide_.model.rotors; ++r) {
      output.set(r, inputs[r] * rotors_[static_cast<std::size_t>(r)].full);
    }
  }

  void set_times(const Setup& setup) {
    const auto steps = static_cast<int>(period_.value());
    const double period = steps * setup.dt();
    if (period > node_step_.value() * (1.0 + 1e-9)) {
      refuse("`period` is ", period, " s, above `node_step` ", node_step_.value(),
             " s: inputs would be used beyond their node; lower `period`");
    }
    guide_.node = nmpc::step_length(guide_.model, node_step_.value());
    guide_.period = nmpc::step_length(guide_.model, period);
    guide_.disturbance_gain = -expm1(-period / disturbance_time_.value());
    setup.period(steps);
  }

  void set_weights() {
    guide_.nodes = static_cast<int>(horizon_.value());
    guide_.weights = {position_weight_.vec3(), velocity_weight_.vec3(), attitude_weight_.vec3(),
                      rate_weight_.vec3(),     input_weight_.value(),   terminal_.value()};
    guide_.least_share = least_share_.value();
    guide_.most_position_error = position_error_.value();
    guide_.most_iterations = static_cast<int>(iterations_.value());
    guide_.most_acceleration = max_acceleration_.value();
    guide_.most_angular = max_angular_.value();
  }

  void declare(const Setup& setup, int nodes, int rotors) {
    box_.configure();
    points_ = preview_.value() ? nodes + 1 : 1;
    control::declare_trajectory(setup, points_, {box_.low(), box_.high()});
    setup.output(Signal::kSrt, rotors);
    setup.buffer(kShares + rotors + nodes * rotors);
    setup.report("solves", "", 1, kSolves);
    setup.report("failures", "", 1, kFailures);
    setup.report("iterations", "", 1, kIterations);
    setup.report("saturated", "", 1, kSaturated);
    setup.report("disturbance", "m/s^2", 3, kAcceleration);
    setup.report("angular_disturbance", "rad/s^2", 3, kAngular);
  }

  nmpc::Motion motion_of(const EnvView<double>& env) const {
    const BodyMotion<double> base = env.body(base_);
    nmpc::Motion motion{base.position,
                        base.velocity,
                        base.rotation,
                        measured_.rates(env, base.angular_velocity),
                        {}};
    for (int r = 0; r < guide_.model.rotors; ++r) {
      const RotorScale& scale = rotors_[static_cast<std::size_t>(r)];
      const double speed = env.rotor_speed(first_rotor_ + r);
      motion.share[r] = scale.constant * (speed * speed) / scale.full;
    }
    return motion;
  }

  /// The motion at the last call. Its positions are not used.
  nmpc::Motion remembered(const Values<double>& buffer) const {
    nmpc::Motion motion{
        {0.0, 0.0, 0.0}, buffer.vec3(kVelocity), buffer.quat(kRotation), buffer.vec3(kRates), {}};
    for (int r = 0; r < guide_.model.rotors; ++r) motion.share[r] = buffer[kShares + r];
    return motion;
  }

  void set_targets(const ConstValues<double>& input, const nmpc::Disturbance& disturbance,
                   nmpc::Target* targets) const {
    for (int k = 0; k <= guide_.nodes; ++k) {
      const ReferencePoint<double> point =
          points_ > 1 ? reference_point(input, k)
                      : nmpc::extrapolated(reference_point(input), k * node_step_.value());
      targets[k] =
          nmpc::target_of(guide_.model, guide_.rows, guide_.least_share, disturbance, point);
    }
  }

  /// Initial guess without a past: the inputs of the reference. Non-finite values leave the inputs
  /// unchanged.
  void begin(const nmpc::Target* targets, double* inputs) const {
    const int rotors = guide_.model.rotors;
    for (int k = 0; k < guide_.nodes; ++k) {
      for (int r = 0; r < rotors; ++r) {
        const double share = targets[k].share[r];
        double& value = inputs[k * rotors + r];
        value = is_finite(share) ? share : max(value, guide_.least_share);
      }
    }
  }

  int first_input() const { return kShares + guide_.model.rotors; }

  void load_inputs(const Values<double>& buffer, double* inputs) const {
    const int n = guide_.nodes * guide_.model.rotors;
    for (int i = 0; i < n; ++i) inputs[i] = buffer[first_input() + i];
  }

  void store(const Values<double>& buffer, const nmpc::Motion& now,
             const nmpc::Disturbance& disturbance, const double* inputs,
             const nmpc::QpResult& result) const {
    const int rotors = guide_.model.rotors;
    int saturated = 0;
    for (int r = 0; r < rotors; ++r) {
      saturated += inputs[r] <= guide_.least_share || inputs[r] >= 1.0 ? 1 : 0;
      buffer.set(kShares + r, now.share[r]);
    }
    buffer.set(kSolves, buffer[kSolves] + 1.0);
    buffer.set(kFailed, result.is_solved ? 0.0 : 1.0);
    buffer.set(kFailures, buffer[kFailures] + buffer[kFailed]);
    buffer.set(kIterations, static_cast<double>(result.iterations));
    buffer.set(kSaturated, static_cast<double>(saturated));
    buffer.set(kAcceleration, disturbance.acceleration);
    buffer.set(kAngular, disturbance.angular_acceleration);
    buffer.set(kVelocity, now.velocity);
    buffer.set(kRotation, now.rotation);
    buffer.set(kRates, now.rates);
    for (int i = 0; i < guide_.nodes * rotors; ++i) buffer.set(first_input() + i, inputs[i]);
  }

  IntegerParameter horizon_{this, integer("horizon", "nodes", 20, between(2, kMostNodes),
                                          "number of predicted steps; times rotors at most 160")};
  RealParameter node_step_{
      this, real("node_step", "s", 0.05, between(1e-3, 1.0), "time from node to node")};
  IntegerParameter period_{this, integer("period", "physics steps", 10, between(1, 1000),
                                         "interval of iterations; at most node_step")};
  BooleanParameter preview_{
      this, boolean("preview", false,
                    "true: the input has horizon + 1 points, one per node_step, the first for now; "
                    "false: one point, extrapolated by its derivatives")};
  RealsParameter position_weight_{
      this, reals("position_weight", "1/m^2", {200.0, 200.0, 200.0}, between(1e-9, 1e9),
                  "weight of squared position errors, W axes")};
  RealsParameter velocity_weight_{
      this, reals("velocity_weight", "s^2/m^2", {10.0, 10.0, 10.0}, between(1e-9, 1e9),
                  "weight of squared velocity errors, W axes")};
  RealsParameter attitude_weight_{
      this, reals("attitude_weight", "1/rad^2", {10.0, 10.0, 10.0}, between(1e-9, 1e9),
                  "weight of squared rotations from the reference's attitude, B axes")};
  RealsParameter rate_weight_{this,
                              reals("rate_weight", "s^2/rad^2", {0.5, 0.5, 0.5}, between(1e-9, 1e9),
                                    "weight of squared rate errors, B axes")};
  RealParameter input_weight_{
      this,
      real(
          "input_weight", "", 5.0, between(1e-9, 1e9),
          "weight of squared shares of a rotor's full thrust, relative to those of the reference")};
  RealParameter terminal_{this, real("terminal_factor", "", 5.0, between(1e-9, 1e9),
                                     "factor on the weights of the last node's errors")};
  RealParameter least_share_{this, real("min_share", "", 0.0, between(0.0, 0.9),
                                        "least share of each rotor's full thrust")};
  RealParameter position_error_{this, real("max_position_error", "m", 2.0, between(1e-3, 1e3),
                                           "a more distant reference is moved to this distance")};
  IntegerParameter iterations_{
      this, integer("max_iterations", "", 500, between(1, 10000),
                    "limit of changes of the active set; beyond it, the last inputs are kept")};
  RealParameter disturbance_time_{this, real("disturbance_time", "s", 0.1, between(1e-3, 1e6),
                                             "time constant of the disturbance estimate")};
  RealParameter max_acceleration_{this,
                                  real("max_disturbance", "m/s^2", 5.0, between(0.0, 100.0),
                                       "limit of the estimated acceleration; 0: no estimate")};
  RealParameter max_angular_{this,
                             real("max_angular_disturbance", "rad/s^2", 20.0, between(0.0, 1e4),
                                  "limit of the estimated angular acceleration")};
  control::MeasuredMotion measured_{this};
  control::PositionBox box_{this};

  nmpc::NmpcProblem guide_;
  std::vector<RotorScale> rotors_;
  int base_ = 0;
  int first_rotor_ = 0;
  int points_ = 1;  ///< of the reference
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Nmpc, "nmpc", "1.0.0",
               "Nonlinear model-predictive control of rotor thrusts [N] along a trajectory, within "
               "the rotors' limits.");
