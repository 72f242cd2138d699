// One environment of a sensor, called as the engine calls it.
#pragma once

#include <cmath>
#include <vector>

#include "tests/unit/plugin_harness.h"

namespace skybody::testing {

using Numbers = std::vector<double>;

/// Resets and senses when it is made.
class SensorRun {
 public:
  explicit SensorRun(const Instance& sensor, std::uint64_t env = 7) : sensor_(sensor) {
    group = sensor.group(1);
    group.key[1] = env;
    begin();
  }

  Group group;

  /// Begins an episode in the present state of the bodies.
  void begin() {
    group.physics_step[0] = 0;
    std::fill(group.state.begin(), group.state.end(), 0);
    std::fill(group.buffer.begin(), group.buffer.end(), 0.0);
    sensor_.call(Instance::Call::kReset, group);
    sensor_.call(Instance::Call::kSense, group);
  }
  /// Ends a physics step: calls the sensor if it is due.
  void step() {
    const auto period = static_cast<std::uint64_t>(std::max(sensor_.declared.period, 1));
    if (++group.physics_step[0] % period == 0) sensor_.call(Instance::Call::kSense, group);
  }
  /// Calls the sensor in the state that `bodies` now have.
  const Numbers& sense() {
    sensor_.call(Instance::Call::kSense, group);
    return group.output;
  }

  // The base: position and velocity in W, turn about W's z, y or x [rad], rates in its own axes.
  void place(double x, double y, double z) { set(0, {x, y, z}); }
  void move(double x, double y, double z) { set(7, {x, y, z}); }
  void spin(double x, double y, double z) { set(10, {x, y, z}); }
  void yaw(double angle) { set(3, {std::cos(0.5 * angle), 0, 0, std::sin(0.5 * angle)}); }
  void pitch(double angle) { set(3, {std::cos(0.5 * angle), 0, std::sin(0.5 * angle), 0}); }
  void roll(double angle) { set(3, {std::cos(0.5 * angle), std::sin(0.5 * angle), 0, 0}); }

 private:
  void set(std::size_t first, const Numbers& values) {
    std::copy(values.begin(), values.end(),
              group.bodies.begin() + static_cast<std::ptrdiff_t>(first));
  }
  const Instance& sensor_;
};

/// Mean and standard deviation of numbers.
struct Spread {
  double mean = 0.0, deviation = 0.0;
  explicit Spread(const Numbers& all) {
    const auto count = static_cast<double>(all.size());
    for (const double x : all) mean += x / count;
    for (const double x : all) deviation += (x - mean) * (x - mean) / count;
    deviation = std::sqrt(deviation);
  }
};

/// Value `k` of `count` readings at rest.
inline Numbers readings(const Instance& sensor, std::size_t k, int count) {
  SensorRun run(sensor);
  Numbers all;
  for (int n = 0; n < count; ++n) {
    for (int s = 0; s < std::max(sensor.declared.period, 1); ++s) run.step();
    all.push_back(run.group.output[k]);
  }
  return all;
}

/// Four standard errors of a mean over `count` draws, and of a deviation.
inline double of_mean(double deviation, int count) { return 4.0 * deviation / std::sqrt(count); }
inline double of_deviation(double deviation, int count) {
  return 4.0 * deviation / std::sqrt(2.0 * count);
}

}  // namespace skybody::testing
