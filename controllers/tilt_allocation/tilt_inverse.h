// Pushes of tilting arms for a wrench, of least norm: the static allocation of M. Kamel, S.
// Verling, O. Elkhatib, C. Sprecher, P. Wulkop, Z. Taylor, R. Siegwart and I. Gilitschenski, The
// Voliro omniorientational hexacopter, IEEE Robotics & Automation Magazine 25(4), 2018, section
// "Control allocation": the wrench is linear in what each arm gives along and across its neutral
// axis, w = A (f_n1, f_s1, f_n2, ...), and A has a constant pseudo-inverse A^T (A A^T)^-1.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "controllers/tilt_allocation/tilt_arms.h"

namespace skybody {

class TiltInverse {
 public:
  TiltInverse() = default;
  /// @throws std::runtime_error where the arms do not reach all forces and moments
  TiltInverse(const TiltArms& arms, const std::string& robot) {
    for (const TiltArm& arm : arms.all()) {
      add_column(arm.normal, arm.moment(arm.normal));
      add_column(arm.side, arm.moment(arm.side));
    }
    invert(robot);
  }

  /// Push of arm i along its neutral axis [N]. @param wrench  force [N], moment [N m]
  template <class Real>
  SKYBODY_INLINE Real along(std::size_t i, const Real (&wrench)[6]) const {
    return push(inverse_[2 * i], wrench);
  }
  /// Across it.
  template <class Real>
  SKYBODY_INLINE Real across(std::size_t i, const Real (&wrench)[6]) const {
    return push(inverse_[2 * i + 1], wrench);
  }

 private:
  static constexpr int kSize = 6;
  struct Column {
    double value[kSize];
  };

  template <class Real>
  static SKYBODY_INLINE Real push(const Column& row, const Real (&wrench)[6]) {
    Real sum = wrench[0] * row.value[0];
    for (int k = 1; k < kSize; ++k) sum += wrench[k] * row.value[k];
    return sum;
  }

  void add_column(const Vec3<double>& f, const Vec3<double>& m) {
    columns_.push_back({{f.x, f.y, f.z, m.x, m.y, m.z}});
  }

  /// Rows of the pseudo-inverse by a Cholesky factor of A A^T, each direction scaled to length 1.
  void invert(const std::string& robot) {
    static const char* const kNames[kSize] = {"force along x", "force along y", "force along z",
                                              "roll torque",   "pitch torque",  "yaw torque"};
    double scale[kSize], factor[kSize][kSize] = {};
    for (int r = 0; r < kSize; ++r) {
      double square = 0.0;
      for (const Column& c : columns_) square += c.value[r] * c.value[r];
      scale[r] = square > 1e-18 ? 1.0 / sqrt(square) : 0.0;
      for (int c = 0; c <= r; ++c) {
        double sum = 0.0;
        for (const Column& x : columns_) sum += x.value[r] * scale[r] * (x.value[c] * scale[c]);
        for (int k = 0; k < c; ++k) sum -= factor[r][k] * factor[c][k];
        if (c < r) {
          factor[r][c] = sum / factor[c][c];
        } else if (sum > 1e-9) {
          factor[r][r] = sqrt(sum);
        } else {
          throw std::runtime_error("the arms of robot `" + robot + "` cannot give " + kNames[r] +
                                   " independently, which tilt_allocation needs: three arms or "
                                   "more with axes that are not parallel");
        }
      }
    }
    for (const Column& column : columns_) {
      Column row;
      double y[kSize];
      for (int r = 0; r < kSize; ++r) {
        y[r] = column.value[r] * scale[r];
        for (int k = 0; k < r; ++k) y[r] -= factor[r][k] * y[k];
        y[r] /= factor[r][r];
      }
      for (int r = kSize - 1; r >= 0; --r) {
        for (int k = r + 1; k < kSize; ++k) y[r] -= factor[k][r] * y[k];
        y[r] /= factor[r][r];
      }
      for (int r = 0; r < kSize; ++r) row.value[r] = y[r] * scale[r];
      inverse_.push_back(row);
    }
  }

  std::vector<Column> columns_, inverse_;
};

}  // namespace skybody
