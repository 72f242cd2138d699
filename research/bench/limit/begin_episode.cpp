#include <initializer_list>

#include "research/bench/limit/hover_task.h"
#include "research/bench/limit/payload_task.h"
#include "research/bench/limit/pin_rod_task.h"
#include "research/bench/limit/team_step.h"

namespace skybody::bench::limit {
namespace {

/// Sebastiano Vigna's splitmix64 (public domain): the next value of a sequence with any seed.
class Draws {
 public:
  Draws(std::uint64_t env, std::uint64_t episode) : state_(env * 0x632be59bd9b4e019u + episode) {}
  double uniform(double low, double high) {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return low + (high - low) * (static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53);
  }

 private:
  std::uint64_t state_;
};

/// The values of one environment in a block.
class Values {
 public:
  Values(double* first, int stride) : first_(first), stride_(stride) {}
  double& operator[](int k) const { return first_[k * stride_]; }

  /// At rest at a drawn position, with that heading.
  /// @param mass  that the rotors carry [kg]
  void place(Draws& draw, double lowest, double yaw, double mass) const {
    const Values& v = *this;
    v[kPosition] = draw.uniform(-5.0, 5.0);
    v[kPosition + 1] = draw.uniform(-5.0, 5.0);
    v[kPosition + 2] = draw.uniform(lowest, 3.0);
    v[kRotation] = cos(0.5 * yaw);
    v[kRotation + 1] = v[kRotation + 2] = 0.0;
    v[kRotation + 3] = sin(0.5 * yaw);
    for (int k = 0; k < 3; ++k) v[kVelocity + k] = v[kSpin + k] = 0.0;
    for (int k = 0; k < 4; ++k) v[kRotor + k] = sqrt(mass * kGravity / (4.0 * kThrust));
  }

 private:
  double* first_;
  int stride_;
};

}  // namespace

[[gnu::noinline]] void begin_hover(double* values, int stride, std::uint64_t env,
                                   std::uint64_t episode) {
  const Values v(values, stride);
  Draws draw(env, episode);
  v.place(draw, 0.3, draw.uniform(-0.72, 0.72), kMass);
  v[kTarget] = draw.uniform(-5.0, 5.0);
  v[kTarget + 1] = draw.uniform(-5.0, 5.0);
  v[kTarget + 2] = draw.uniform(0.5, 3.0);
  v[kTargetYaw] = draw.uniform(-0.72, 0.72);
  v[kHoverValues] = 0.0;
}

[[gnu::noinline]] void begin_payload(double* values, int stride, std::uint64_t env,
                                     std::uint64_t episode) {
  const Values v(values, stride);
  Draws draw(env, episode);
  v.place(draw, 1.5, 0.0, kMass + kRod.mass + kBob.mass);
  for (const int body : {kRodRotation, kBobRotation}) {
    v[body] = 1.0;
    for (int k = 1; k < 7; ++k) v[body + k] = 0.0;
  }
  v[kCarrierValues] = 0.0;
}

[[gnu::noinline]] void begin_pin_rod(double* values, int stride, std::uint64_t env,
                                     std::uint64_t episode) {
  const Values v(values, stride);
  Draws draw(env, episode);
  v.place(draw, 1.5, 0.0, kMass + kPinRod.mass);
  v[kPinAngle] = v[kPinRate] = 0.0;
  v[kSwingerValues] = 0.0;
}

[[gnu::noinline]] void begin_team(double* values, int stride, int robots, std::uint64_t env,
                                  std::uint64_t episode) {
  Draws draw(env, episode);
  const double x = draw.uniform(-10.0, 10.0), y = draw.uniform(-10.0, 10.0);
  const double z = draw.uniform(1.5, 11.5);
  for (int i = 0; i < robots; ++i) {
    const Values v(values + i * kFlyerValues * stride, stride);
    v.place(draw, z, 0.0, kMass);
    v[kPosition] = x + 0.7 * i;
    v[kPosition + 1] = y + 0.7 * i;
    v[kPosition + 2] = z;
  }
  const Values rest(values + robots * kFlyerValues * stride, stride);
  rest[0] = x + draw.uniform(-2.0, 2.0);
  rest[1] = y + draw.uniform(-2.0, 2.0);
  rest[2] = z + draw.uniform(-2.0, -0.5);
  rest[3] = 0.0;
}

}  // namespace skybody::bench::limit
