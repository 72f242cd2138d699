// Hand-written loops over Simbody of one hovering QDrone2: the baseline for the engine.
#pragma once

#include <memory>

namespace skybody::bench {

/// The world of all loops: a QDrone2 in the air, rotors with lag, gravity. SI units.
struct Hover {
  double dt = 0.001, mass = 1.54, g = 9.81, height = 5.0;
  double kf = 1.9533e-6, km = 2.8401e-8, tau_up = 0.0125, tau_down = 0.025, max_speed = 2246.0;
  double inertia[3] = {0.0147, 0.0169, 0.0294};
  double hub[4][2] = {{0.1, 0.12}, {0.1, -0.12}, {-0.1, 0.12}, {-0.1, -0.12}};
  int direction[4] = {1, -1, -1, 1};
  double start = 1390.0;    ///< of every rotor
  double command = 1391.0;  ///< of every rotor, slightly above hover
};
inline constexpr Hover kHover{};

/// The default rule (kMidpointRule), written by hand.
class BareLoop {
 public:
  virtual ~BareLoop() = default;
  virtual void step() = 0;
  virtual double height() const = 0;
  /// Multiplies the body's mass and inertia by `scale`, which requires a new topology, and restores
  /// the initial state.
  virtual void rebuild(double scale) = 0;
};

/// Without the operator: Force::Gravity and Force::DiscreteForces, realize(Acceleration), the usual
/// way. With it: forces passed to calcAccelerationIgnoringConstraints, the fastest known way.
std::unique_ptr<BareLoop> make_bare_loop(bool with_operator);

}  // namespace skybody::bench
