// Shared code of the C++ programs of research/peers: command line, the work, best-of trials, and a
// line of JSON for each measurement (protocol: README.md).
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

namespace skybody::bench {

/// The QDrone2 of scenarios/models/qdrone2, its rotors merged into the base (as in vehicle.py), its
/// origin at the centre of mass, which is sufficient here. SI units.
struct Quadrotor {
  double dt = 0.001, g = 9.81, height = 1.5, mass = 1.54;
  double inertia[3] = {0.0147298625974, 0.0167867337974, 0.0293337112};
  double hub[4][2] = {{0.1016, 0.127}, {0.1016, -0.127}, {-0.1016, 0.127}, {-0.1016, -0.127}};
  double direction[4] = {1, -1, -1, 1};         ///< +1: counterclockwise seen from above
  double moment_ratio = 2.8401e-8 / 1.9533e-6;  ///< reaction moment per thrust [m]
  double spacing = 0.7;                         ///< of robots in a world, along x and y
  int rotors = 4;
};
inline constexpr Quadrotor kQuadrotor{};

/// Position, quaternion (w first), velocity, angular velocity.
inline constexpr int kStates = 13;
/// Steps of a flight, after which the vehicles return to their initial states: they stay in the
/// air.
inline constexpr int kFlight = 1000;

struct Effort {
  double seconds = 0.2;  ///< of a trial
  int trials = 5;        ///< the best one counts
  bool quick = false;
  std::vector<int> robots() const {
    return quick ? std::vector{1, 20} : std::vector{1, 2, 5, 10, 20};
  }
};

/// A bad command line prints one message and exits with code 2.
inline Effort parse(int count, char** words) {
  const auto refuse = [&](const std::string& why) {
    std::fprintf(stderr, "%s: %s; usage: [--seconds S] [--trials T] [--quick]\n", words[0],
                 why.c_str());
    std::exit(2);
  };
  const auto number = [&](int k, auto& value) {
    const std::string_view text = k < count ? words[k] : "";
    const auto [end, error] = std::from_chars(text.begin(), text.end(), value);
    if (error != std::errc() || end != text.end() || !(value > 0) ||
        !std::isfinite(static_cast<double>(value))) {
      refuse(std::string(words[k - 1]) + " needs a number above 0, not '" + std::string(text) +
             "'");
    }
  };
  Effort effort;
  for (int k = 1; k < count; ++k) {
    const std::string_view word = words[k];
    if (word == "--quick") {
      effort.quick = true;
    } else if (word == "--seconds") {
      number(++k, effort.seconds);
    } else if (word == "--trials") {
      number(++k, effort.trials);
    } else {
      refuse("unknown argument '" + std::string(word) + "'");
    }
  }
  return effort;
}

/// Force along the body's z axis and moment about the body's axes.
struct Wrench {
  double thrust, moment[3];
};

inline Wrench rotor_wrench(const double thrusts[4]) {
  Wrench sum{};
  for (int k = 0; k < 4; ++k) {
    sum.thrust += thrusts[k];
    sum.moment[0] += kQuadrotor.hub[k][1] * thrusts[k];
    sum.moment[1] -= kQuadrotor.hub[k][0] * thrusts[k];
    sum.moment[2] -= kQuadrotor.direction[k] * kQuadrotor.moment_ratio * thrusts[k];
  }
  return sum;
}

/// Rotor thrusts [N] of all robots for a round of steps: near hover, different at each step. They
/// shake the vehicle about all its axes and sum to zero over the round.
class Commands {
 public:
  explicit Commands(int robots) : width_(4 * robots), thrusts_(kRound * width_) {
    const double hover = kQuadrotor.mass * kQuadrotor.g / 4;
    for (int step = 0; step < kRound; ++step) {
      const double angle = 2 * std::numbers::pi * step / kRound;
      for (int k = 0; k < width_; ++k) {
        const double* hub = kQuadrotor.hub[k % 4];
        const double shake = std::cos(angle) + (hub[1] > 0 ? 1 : -1) * std::cos(2 * angle) +
                             (hub[0] > 0 ? 1 : -1) * std::cos(3 * angle) +
                             kQuadrotor.direction[k % 4] * std::cos(4 * angle);
        thrusts_[step * width_ + k] = hover * (1 + 0.01 * shake);
      }
    }
  }
  const double* at(int step) const { return &thrusts_[step % kRound * width_]; }

 private:
  static constexpr int kRound = 64;  // steps
  int width_;
  std::vector<double> thrusts_;
};

/// Worlds per second of the best trial. A world has start() and step(thrusts, states).
template <class World>
double best_rate(World& world, int robots, const Effort& effort, std::vector<double>& states) {
  using Clock = std::chrono::steady_clock;
  const Commands commands(robots);
  states.assign(static_cast<std::size_t>(robots * kStates), 0.0);
  const auto fly = [&] {
    world.start();
    for (int step = 0; step < kFlight; ++step) world.step(commands.at(step), states.data());
  };
  fly();
  double best = 0;
  for (int trial = 0; trial < effort.trials; ++trial) {
    const Clock::time_point start = Clock::now();
    double seconds = 0;
    long steps = 0;
    for (; seconds < effort.seconds; steps += kFlight) {
      fly();
      seconds = std::chrono::duration<double>(Clock::now() - start).count();
    }
    best = std::max(best, static_cast<double>(steps) / seconds);
  }
  return best;
}

struct Peer {
  const char *name, *version, *engine, *differs;
};

inline bool near(double value, double expected) {
  return std::abs(value - expected) < 0.1 * std::abs(expected);
}

/// Whether vehicles climb and roll as expected on a tenth more thrust, the left rotors' a fifth
/// more and the right ones' as at hover. If commands did not reach the forces, any simulator would
/// be fast.
template <class World>
bool obeys(World& world, int robots) {
  const Quadrotor& quad = kQuadrotor;
  const double hover = quad.mass * quad.g / 4;
  std::vector<double> thrusts(static_cast<std::size_t>(4 * robots), hover);
  for (int k = 0; k < 4 * robots; ++k) {
    if (quad.hub[k % 4][1] > 0) thrusts[static_cast<std::size_t>(k)] *= 1.2;
  }
  std::vector<double> states(static_cast<std::size_t>(kStates * robots));
  constexpr int kSteps = 10;
  world.start();
  for (int step = 0; step < kSteps; ++step) world.step(thrusts.data(), states.data());
  const double seconds = kSteps * quad.dt;
  const double roll = 2 * 0.2 * hover * quad.hub[0][1] / quad.inertia[0] * seconds;
  for (const double* state = states.data(); state != states.data() + states.size();
       state += kStates) {
    if (!near(state[9], 0.1 * quad.g * seconds) || !near(state[10], roll)) return false;
  }
  return true;
}

/// Whether all vehicles are near their initial positions.
inline bool hover(const std::vector<double>& states) {
  for (std::size_t k = 2; k < states.size(); k += kStates) {
    if (!(std::abs(states[k] - kQuadrotor.height) < 0.1)) return false;
  }
  return true;
}

/// Measures a world and prints its line; rejects it if its vehicles did not fly as expected.
template <class World>
void print_row(const Peer& peer, const char* mode, World& world, int robots, const Effort& effort) {
  std::vector<double> states;
  const double rate = best_rate(world, robots, effort, states);
  if (!hover(states) || !obeys(world, robots)) {
    std::printf(
        "{\"peer\": \"%s\", \"skipped\": \"%s, %d robots: a vehicle did not fly as it "
        "should\"}\n",
        peer.name, mode, robots);
    return;
  }
  std::printf(
      "{\"peer\": \"%s\", \"version\": \"%s\", \"engine\": \"%s\", \"task\": \"%s\", \"envs\": 1, "
      "\"robots\": %d, \"substeps\": 1, \"cores\": 1, \"rate\": %.1f, \"unit\": \"physics "
      "steps/s\", \"differs\": \"%s\", \"mode\": \"%s\"}\n",
      peer.name, peer.version, peer.engine, robots == 1 ? "hover" : "robots", robots, rate,
      peer.differs, mode);
  std::fflush(stdout);
}

}  // namespace skybody::bench
