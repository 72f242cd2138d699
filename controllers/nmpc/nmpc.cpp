// Nonlinear model-predictive control of single rotor thrusts along a trajectory.
#include <stdexcept>
#include <string>
#include <vector>

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
      throw std::runtime_error(
          "`horizon` " + std::to_string(nodes) + " times " + std::to_string(rotors) +
          " rotors are " + std::to_string(nodes * rotors) + " inputs; allowed: up to " +
          std::to_string(kMostInputs) + ": shorten it to " + std::to_string(kMostInputs / rotors));
    }
    for (const RotorInfo& rotor : setup.rotors_of(robot)) {
      rotors_.push_back(
          {control::full_thrust(rotor), rotor.constants[SKYBODY_ROTOR_THRUST_CONSTANT]});
    }
    if (measured_.value() == "imu") {
      force_sensor_ = setup.sensor(imu_.value(), "specific_force");
      rate_sensor_ = setup.sensor(imu_.value(), "angular_rate");
    }
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
    const nmpc::Motion now = measured(env);
    nmpc::Disturbance disturbance{buffer.vec3(kAcceleration), buffer.vec3(kAngular)};
    double inputs[kMostInputs];
    load_inputs(buffer, inputs);
    const bool is_first = buffer[kSolves] == 0.0;
    if (!is_first) {
      nmpc::Observed observed = nmpc::observe(guide_, remembered(buffer), inputs, now);
      if (force_sensor_ >= 0) {
        const Vec3<double> force = sensed(env, force_sensor_);
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
      throw std::runtime_error("`period` is " + to_text(period) + " s, above `node_step` " +
                               to_text(node_step_.value()) +
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
    const Vec3<double> low = position_min_.vec3(), high = position_max_.vec3();
    control::require_order("position_min[0]", low.x, "position_max[0]", high.x);
    control::require_order("position_min[1]", low.y, "position_max[1]", high.y);
    control::require_order("position_min[2]", low.z, "position_max[2]", high.z);
    points_ = preview_.value() ? nodes + 1 : 1;
    control::declare_trajectory(setup, points_, {low, high});
    setup.output(Signal::kSrt, rotors);
    setup.buffer(kShares + rotors + nodes * rotors);
    setup.report("solves", "", 1, kSolves);
    setup.report("failures", "", 1, kFailures);
    setup.report("iterations", "", 1, kIterations);
    setup.report("saturated", "", 1, kSaturated);
    setup.report("disturbance", "m/s^2", 3, kAcceleration);
    setup.report("angular_disturbance", "rad/s^2", 3, kAngular);
  }

  static Vec3<double> sensed(const EnvView<double>& env, int first) {
    return {env.sensor(first), env.sensor(first + 1), env.sensor(first + 2)};
  }

  nmpc::Motion measured(const EnvView<double>& env) const {
    const BodyMotion<double> base = env.body(base_);
    nmpc::Motion motion{base.position, base.velocity, base.rotation, base.angular_velocity, {}};
    if (rate_sensor_ >= 0) motion.rates = sensed(env, rate_sensor_);
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

  IntegerParameter horizon_{this,
                            {.name = "horizon",
                             .unit = "nodes",
                             .value = 20,
                             .min = 2,
                             .max = kMostNodes,
                             .doc = "number of predicted steps; times rotors at most 160"}};
  RealParameter node_step_{this,
                           {.name = "node_step",
                            .unit = "s",
                            .value = 0.05,
                            .min = 1e-3,
                            .max = 1.0,
                            .doc = "time from node to node"}};
  IntegerParameter period_{this,
                           {.name = "period",
                            .unit = "physics steps",
                            .value = 10,
                            .min = 1,
                            .max = 1000,
                            .doc = "interval of iterations; at most node_step"}};
  BooleanParameter preview_{
      this,
      {.name = "preview",
       .value = false,
       .doc = "true: the input has horizon + 1 points, one per node_step, the first for now; "
              "false: one point, extrapolated by its derivatives"}};
  RealsParameter position_weight_{this,
                                  {.name = "position_weight",
                                   .unit = "1/m^2",
                                   .values = {200.0, 200.0, 200.0},
                                   .min = 1e-9,
                                   .max = 1e9,
                                   .doc = "weight of squared position errors, W axes"}};
  RealsParameter velocity_weight_{this,
                                  {.name = "velocity_weight",
                                   .unit = "s^2/m^2",
                                   .values = {10.0, 10.0, 10.0},
                                   .min = 1e-9,
                                   .max = 1e9,
                                   .doc = "weight of squared velocity errors, W axes"}};
  RealsParameter attitude_weight_{
      this,
      {.name = "attitude_weight",
       .unit = "1/rad^2",
       .values = {10.0, 10.0, 10.0},
       .min = 1e-9,
       .max = 1e9,
       .doc = "weight of squared rotations from the reference's attitude, B axes"}};
  RealsParameter rate_weight_{this,
                              {.name = "rate_weight",
                               .unit = "s^2/rad^2",
                               .values = {0.5, 0.5, 0.5},
                               .min = 1e-9,
                               .max = 1e9,
                               .doc = "weight of squared rate errors, B axes"}};
  RealParameter input_weight_{this,
                              {.name = "input_weight",
                               .value = 5.0,
                               .min = 1e-9,
                               .max = 1e9,
                               .doc = "weight of squared shares of a rotor's full thrust, relative "
                                      "to those of the reference"}};
  RealParameter terminal_{this,
                          {.name = "terminal_factor",
                           .value = 5.0,
                           .min = 1e-9,
                           .max = 1e9,
                           .doc = "factor on the weights of the last node's errors"}};
  RealParameter least_share_{this,
                             {.name = "min_share",
                              .value = 0.0,
                              .min = 0.0,
                              .max = 0.9,
                              .doc = "least share of each rotor's full thrust"}};
  RealParameter position_error_{this,
                                {.name = "max_position_error",
                                 .unit = "m",
                                 .value = 2.0,
                                 .min = 1e-3,
                                 .max = 1e3,
                                 .doc = "a more distant reference is moved to this distance"}};
  IntegerParameter iterations_{
      this,
      {.name = "max_iterations",
       .value = 500,
       .min = 1,
       .max = 10000,
       .doc = "limit of changes of the active set; beyond it, the last inputs are kept"}};
  RealParameter disturbance_time_{this,
                                  {.name = "disturbance_time",
                                   .unit = "s",
                                   .value = 0.1,
                                   .min = 1e-3,
                                   .max = 1e6,
                                   .doc = "time constant of the disturbance estimate"}};
  RealParameter max_acceleration_{this,
                                  {.name = "max_disturbance",
                                   .unit = "m/s^2",
                                   .value = 5.0,
                                   .min = 0.0,
                                   .max = 100.0,
                                   .doc = "limit of the estimated acceleration; 0: no estimate"}};
  RealParameter max_angular_{this,
                             {.name = "max_angular_disturbance",
                              .unit = "rad/s^2",
                              .value = 20.0,
                              .min = 0.0,
                              .max = 1e4,
                              .doc = "limit of the estimated angular acceleration"}};
  TextParameter measured_{this,
                          {.name = "measured",
                           .value = "state",
                           .choices = {"state", "imu"},
                           .doc = "source of rates and accelerations"}};
  TextParameter imu_{
      this,
      {.name = "imu",
       .value = "imu",
       .doc = "measured: imu: name of the sensor, which must be at the base's frame"}};
  RealsParameter position_min_{this,
                               {.name = "position_min",
                                .unit = "m",
                                .values = {-5.0, -5.0, 0.5},
                                .doc = "position for action -1 (W)"}};
  RealsParameter position_max_{this,
                               {.name = "position_max",
                                .unit = "m",
                                .values = {5.0, 5.0, 3.0},
                                .doc = "position for action +1 (W)"}};

  nmpc::NmpcProblem guide_;
  std::vector<RotorScale> rotors_;
  int base_ = 0;
  int first_rotor_ = 0;
  int force_sensor_ = -1, rate_sensor_ = -1;  ///< -1: from the state
  int points_ = 1;                            ///< of the reference
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Nmpc, "nmpc", "1.0.0",
               "Nonlinear model-predictive control of rotor thrusts [N] along a trajectory, within "
               "the rotors' limits.");
