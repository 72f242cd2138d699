// Error covariance of an inertial navigation filter, in lanes. Order of the 16 errors: position,
// velocity (W), rotation (body axes), bias of accelerometer, bias of gyroscope, altitude of W's
// origin as the barometer shows it.
#pragma once

#include <skybody/plugin.h>

namespace skybody::ekf {

inline constexpr int kErrors = 16, kPosition = 0, kVelocity = 3, kRotation = 6, kForceBias = 9,
                     kRateBias = 12, kOrigin = 15;
/// Words of the upper triangle.
inline constexpr int kCovarianceWords = kErrors * (kErrors + 1) / 2;

/// Errors in the order of the covariance.
template <class Real>
struct Errors {
  Real value[kErrors];

  Vec3<Real> part(int first) const { return {value[first], value[first + 1], value[first + 2]}; }
};

/// A measurement of up to three errors: sum of factor[k] times error place[k].
template <class Real>
struct Row {
  int count;
  int place[3];
  Real factor[3];
};

template <class Real>
class Covariance {
 public:
  /// From standard deviations of the five vectors, and of the first altitude, from which the
  /// origin follows by the first height: their errors are opposite.
  Covariance(const Vec3<Real> (&deviations)[5], const Real& altitude) {
    for (int i = 0; i < kErrors; ++i) {
      for (int j = 0; j < kErrors; ++j) p_[i][j] = Real(0.0);
    }
    for (int i = 0; i < kOrigin; ++i) {
      const Vec3<Real>& d = deviations[i / 3];
      p_[i][i] = square(i % 3 == 0 ? d.x : i % 3 == 1 ? d.y : d.z);
    }
    const int height = kPosition + 2;
    p_[kOrigin][kOrigin] = p_[height][height] + square(altitude);
    p_[kOrigin][height] = p_[height][kOrigin] = -p_[height][height];
  }
  Covariance(const Values<Real>& words, int first) {
    for (int i = 0, k = first; i < kErrors; ++i) {
      for (int j = i; j < kErrors; ++j) p_[i][j] = p_[j][i] = words[k++];
    }
  }
  void store(const MaskOf<Real>& where, const Values<Real>& words, int first) const {
    for (int i = 0, k = first; i < kErrors; ++i) {
      for (int j = i; j < kErrors; ++j, ++k) words.set(k, select(where, p_[i][j], words[k]));
    }
  }
  Real variance(int i) const { return p_[i][i]; }

  /// P = F P F^T + Q over `dt`. F of an error e: position += dt velocity, velocity -= dt R (force x
  /// rotation + force bias), rotation -= dt (rate x rotation + rate bias).
  /// @param density  variances per second of velocity, rotation, both biases and the origin
  void predict(const Mat3<Real>& axes, const Vec3<Real>& force, const Vec3<Real>& rate,
               const Real& dt, const Real (&density)[5]) {
    for (int j = 0; j < kErrors; ++j) {
      advance(axes, force, rate, dt, [&](int i) -> Real& { return p_[i][j]; });
    }
    for (int i = 0; i < kErrors; ++i) {
      advance(axes, force, rate, dt, [&](int j) -> Real& { return p_[i][j]; });
    }
    for (int i = kVelocity; i < kErrors; ++i) p_[i][i] += density[i / 3 - 1] * dt;
    for (int i = 0; i < kErrors; ++i) {
      for (int j = 0; j < i; ++j) p_[i][j] = p_[j][i];
    }
  }

  /// Takes a measurement of the errors where `where` holds, and adds its correction to `errors`.
  /// @param seen  measured minus predicted value   @param variance  of the measurement
  void update(const MaskOf<Real>& where, const Row<Real>& row, const Real& seen,
              const Real& variance, Errors<Real>& errors) {
    Real cross[kErrors];
    for (int i = 0; i < kErrors; ++i) {
      cross[i] = p_[i][row.place[0]] * row.factor[0];
      for (int k = 1; k < row.count; ++k) cross[i] += p_[i][row.place[k]] * row.factor[k];
    }
    Real total = variance, known(0.0);
    for (int k = 0; k < row.count; ++k) {
      total += row.factor[k] * cross[row.place[k]];
      known += row.factor[k] * errors.value[row.place[k]];
    }
    const Real gain = select(where, 1.0 / total, Real(0.0));
    const Real step = gain * select(where, seen - known, Real(0.0));
    for (int i = 0; i < kErrors; ++i) {
      errors.value[i] += cross[i] * step;
      const Real weight = cross[i] * gain;
      for (int j = i; j < kErrors; ++j) p_[i][j] = p_[j][i] = p_[i][j] - weight * cross[j];
    }
  }

 private:
  /// Multiplies one column (or row) by F.
  template <class Entry>
  static void advance(const Mat3<Real>& axes, const Vec3<Real>& force, const Vec3<Real>& rate,
                      const Real& dt, const Entry& entry) {
    const auto part = [&](int first) {
      return Vec3<Real>{entry(first), entry(first + 1), entry(first + 2)};
    };
    const auto add = [&](int first, const Vec3<Real>& v) {
      entry(first) += v.x;
      entry(first + 1) += v.y;
      entry(first + 2) += v.z;
    };
    const Vec3<Real> velocity = part(kVelocity), rotation = part(kRotation);
    const Vec3<Real> push = axes * (cross(force, rotation) + part(kForceBias));
    const Vec3<Real> turn = cross(rate, rotation) + part(kRateBias);
    add(kPosition, velocity * dt);
    add(kVelocity, push * -dt);
    add(kRotation, turn * -dt);
  }

  Real p_[kErrors][kErrors];
};

}  // namespace skybody::ekf
