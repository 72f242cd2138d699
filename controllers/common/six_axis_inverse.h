// Pseudo-inverse for a wrench, of least norm: f = A^T (A A^T)^-1 w. Column i of A is the force and
// the moment of one newton of push i about the robot's centre of mass, axes of the base.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace skybody::control {

class SixAxisInverse {
 public:
  static constexpr int kSize = 6;  ///< force [N], then moment [N m]

  /// Adds a push. @param force, moment  of one newton of the push
  void add(const Vec3<double>& force, const Vec3<double>& moment) {
    columns_.push_back({{force.x, force.y, force.z, moment.x, moment.y, moment.z}});
  }

  /// Rows of the pseudo-inverse by a Cholesky factor of A A^T, each direction scaled to length 1.
  /// @param whose, need  parts of the message: "WHOSE cannot give yaw torque independently, which
  ///     NEED"
  /// @throws std::runtime_error if the pushes do not reach all six directions
  void invert(const std::string& whose, const std::string& need) {
    static const char* const kNames[kSize] = {"force along x", "force along y", "force along z",
                                              "roll torque",   "pitch torque",  "yaw torque"};
    double scale[kSize], factor[kSize][kSize] = {};
    for (int r = 0; r < kSize; ++r) {
      double square = 0.0;
      for (const Row& c : columns_) square += c.value[r] * c.value[r];
      scale[r] = square > 1e-18 ? 1.0 / sqrt(square) : 0.0;
      for (int c = 0; c <= r; ++c) {
        double sum = 0.0;
        for (const Row& x : columns_) sum += x.value[r] * scale[r] * (x.value[c] * scale[c]);
        for (int k = 0; k < c; ++k) sum -= factor[r][k] * factor[c][k];
        if (c < r) {
          factor[r][c] = sum / factor[c][c];
        } else if (sum > 1e-9) {
          factor[r][r] = sqrt(sum);
        } else {
          refuse(whose, " cannot give ", kNames[r], " independently, which ", need);
        }
      }
    }
    for (const Row& column : columns_) {
      Row row;
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
      rows_.push_back(row);
    }
  }

  /// Value k of row i of the pseudo-inverse.
  double at(std::size_t i, int k) const { return rows_[i].value[k]; }

  /// Push i [N]. @param wrench  force [N], moment [N m]
  template <class Real>
  SKYBODY_INLINE Real push(std::size_t i, const Real (&wrench)[6]) const {
    const Row& row = rows_[i];
    Real sum = wrench[0] * row.value[0];
    for (int k = 1; k < kSize; ++k) sum += wrench[k] * row.value[k];
    return sum;
  }

 private:
  struct Row {
    double value[kSize];
  };

  std::vector<Row> columns_, rows_;
};

}  // namespace skybody::control
