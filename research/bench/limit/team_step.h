// A step of the environments of one block in which N QDrone2 fly in formation: the scenarios
// formation_2 ... formation_20 in the air, with the joint observation and the team's reward. Robots
// are stepped one after another; the relative values of a pair are computed once and written to
// both.
#pragma once

#include <cstdint>

#include "research/bench/limit/free_flight.h"
#include "research/bench/limit/loop.h"
#include "research/bench/limit/rows.h"

namespace skybody::bench::limit {

/// The radius of the polygon of a formation of `count` robots, as in its scenario [m].
constexpr double formation_radius(int count) { return count == 20 ? 1.6 : 1.0; }

/// Begins an episode of one environment: the robots on their diagonal at a drawn position, the
/// target drawn near the first one, rotors at hover speed.
/// @param values  its first value; consecutive values are `stride` doubles apart
void begin_team(double* values, int stride, int robots, std::uint64_t env, std::uint64_t episode);

/// @tparam R  a double, a pack, or two   @tparam N  robots
template <class R, int N>
class TeamStep {
 public:
  using Real = R;
  static constexpr int W = LaneLoads<Real>::kCount;
  static constexpr int kTarget = N * kFlyerValues, kStep = kTarget + 3, kValues = kStep + 1;
  static constexpr int kOwn = 18, kSight = 16, kRobotRow = kOwn + (N - 1) * kSight;
  static constexpr int kObservation = N * kRobotRow, kActions = 4 * N;
  static constexpr double kHorizon = 20000.0;
  using Memory = Block<W, kValues>;

  SKYBODY_INLINE explicit TeamStep(Memory& block) : block_(block) {}

  SKYBODY_INLINE void run(std::uint64_t first, const Rows& rows, int repeats) {
    for (int i = 0; i < N; ++i) fly_robot(i, rows.action + 4 * i, repeats);
    L::store(block_.value[kStep], get(kStep) + 1.0);
    begin_again(first, rows.ended);
    observe(rows);
  }

 private:
  using L = LaneLoads<Real>;
  SKYBODY_INLINE Real get(int k) const { return L::load(block_.value[k]); }
  SKYBODY_INLINE Vec3<Real> vec3(int k) const { return {get(k), get(k + 1), get(k + 2)}; }
  SKYBODY_INLINE Vec3<Real> position(int i) const { return vec3(i * kFlyerValues + kPosition); }

  SKYBODY_INLINE void fly_robot(int i, const float* actions, int repeats) {
    constexpr double kSpeedScale = 1150.0;  // rotor speed per (action + 1) [rad/s]
    Flyer<Real> flyer;
    for (int k = 0; k < kFlyerValues; ++k) flyer_value(flyer, k) = get(i * kFlyerValues + k);
    Real column[4], command[4];
    read_columns(actions, column, kActions);
    for (int k = 0; k < 4; ++k) {
      const Real clipped = smaller(larger(column[k], Real(-1.0)), Real(1.0));
      command[k] = smaller(clipped * kSpeedScale + kSpeedScale, Real(kMaxRotorSpeed));
    }
    for (int k = 0; k < repeats; ++k) limit::fly(flyer, command);
    for (int k = 0; k < kFlyerValues; ++k) {
      L::store(block_.value[i * kFlyerValues + k], flyer_value(flyer, k));
    }
  }

  SKYBODY_INLINE void begin_again(std::uint64_t first, const std::uint8_t* ended) {
    for (int l = 0; l < W; ++l) {
      if (ended[l] == 0) [[likely]]
        continue;
      begin_team(&block_.value[0][l], W, N, first + static_cast<unsigned>(l), block_.episode[l]++);
    }
  }

  SKYBODY_INLINE void observe(const Rows& rows) {
    Vec3<Real> sum{Real(0.0), Real(0.0), Real(0.0)};
    Real forward(0.0);
    for (int i = 0; i < N; ++i) {
      const Mat3<Real> axes = write_own(i, rows.observation + i * kRobotRow);
      sum += position(i);
      forward += axes.m[0];
    }
    Real nearest(1e300);
    for (int j = 1; j < N; ++j) {
      for (int i = 0; i < j; ++i) nearest = smaller(nearest, write_pair(i, j, rows.observation));
    }
    const Vec3<Real> centroid = sum * Real(1.0 / N);
    const Real reward =
        reward_of(nearest, formation_error(centroid), centroid, forward * (1.0 / N));
    const Real step = get(kStep);
    write_floats(pick(step > Real(0.0), reward, Real(0.0)), rows.reward);
    const std::uint32_t over = bits(step > Real(kHorizon - 0.5));
    for (int l = 0; l < W; ++l) rows.ended[l] = static_cast<std::uint8_t>((over >> l & 1u) << 1);
  }

  /// Writes a robot's own part of the observation. @returns its axes
  SKYBODY_INLINE Mat3<Real> write_own(int i, float* row) {
    const int at = i * kFlyerValues;
    const Quat<Real> q{get(at + kRotation), get(at + kRotation + 1), get(at + kRotation + 2),
                       get(at + kRotation + 3)};
    const Mat3<Real> r = to_mat3(q);
    const Vec3<Real> error = vec3(kTarget) - position(i), v = vec3(at + kVelocity);
    const Vec3<Real> w = vec3(at + kSpin);
    const Real own[kOwn] = {error.x, error.y, error.z, v.x,    v.y,    v.z,
                            r.m[0],  r.m[1],  r.m[2],  r.m[3], r.m[4], r.m[5],
                            r.m[6],  r.m[7],  r.m[8],  w.x,    w.y,    w.z};
    write_values(own, row, kObservation);
    const Real motion[12] = {v.x,    v.y,    v.z,    r.m[0], r.m[1], r.m[2],
                             r.m[3], r.m[4], r.m[5], r.m[6], r.m[7], r.m[8]};
    write_values(motion, motion_[i][0], 12);
    return r;
  }

  /// Writes the relative observations of robots i and j, i < j. @returns their distance
  SKYBODY_INLINE Real write_pair(int i, int j, float* rows) const {
    const Vec3<Real> offset = position(j) - position(i);
    const Real distance = root(squared_norm(offset));
    const Real here[4] = {offset.x, offset.y, offset.z, distance};
    const Real there[4] = {0.0 - offset.x, 0.0 - offset.y, 0.0 - offset.z, distance};
    write_sight(here, j, rows + i * kRobotRow + kOwn + (j - 1) * kSight);
    write_sight(there, i, rows + j * kRobotRow + kOwn + i * kSight);
    return distance;
  }
  /// @param seen  the observed robot
  SKYBODY_INLINE void write_sight(const Real (&values)[4], int seen, float* row) const {
    write_values(values, row, kObservation);
    for (int l = 0; l < W; ++l, row += kObservation) {
      std::memcpy(row + 4, motion_[seen][l], 12 * sizeof(float));
    }
  }

  /// Hausdorff distance of the robots from the formation's positions about their centroid [m].
  SKYBODY_INLINE Real formation_error(const Vec3<Real>& centroid) const {
    Real from_place[N], farthest(0.0);
    for (int j = 0; j < N; ++j) from_place[j] = Real(1e300);
    for (int i = 0; i < N; ++i) {
      const Vec3<Real> robot = position(i) - centroid;
      Real nearest(1e300);
      for (int j = 0; j < N; ++j) {
        const Real x = robot.x - places().x[j], y = robot.y - places().y[j];
        const Real square = (x * x + y * y) + robot.z * robot.z;
        nearest = smaller(nearest, square);
        from_place[j] = smaller(from_place[j], square);
      }
      farthest = larger(farthest, nearest);
    }
    for (int j = 0; j < N; ++j) farthest = larger(farthest, from_place[j]);
    return root(farthest);
  }

  SKYBODY_INLINE Real reward_of(const Real& nearest, const Real& error, const Vec3<Real>& centroid,
                                const Real& forward) const {
    const Real ratio = nearest * 2.0;
    const Real separation = smaller(ratio * ratio, Real(1.0));
    const Real formation = 1.0 / (1.0 + 2.56 * (error * error));
    const Real arrival = exponential(0.0 - root(squared_norm(centroid - vec3(kTarget))));
    return separation * (formation + formation * (arrival + forward) + 0.4 * arrival);
  }

  /// Corners of the polygon [m]; with five or more robots the first one is in the middle.
  struct Places {
    double x[N], y[N];
    Places() {
      constexpr int kFirst = N >= 5 ? 1 : 0;
      x[0] = y[0] = 0.0;
      for (int i = kFirst; i < N; ++i) {
        const SinCos<double> angle = sincos(kTwoPi * (i - kFirst) / (N - kFirst));
        x[i] = formation_radius(N) * angle.cos;
        y[i] = formation_radius(N) * angle.sin;
      }
    }
  };
  static const Places& places() {
    static const Places made;
    return made;
  }

  Memory& block_;
  alignas(64) float motion_[N][W][12];  ///< velocity and axes, for the other robots
};

}  // namespace skybody::bench::limit
