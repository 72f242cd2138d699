// The pseudo-inverse P = A^T (A A^T)^-1 of the rotors' effects, of least norm. Column i of A is the
// thrust and the torque of one newton of rotor i (rotor_effects.h).
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace skybody::control {

class PseudoInverse {
 public:
  /// P, N x 4, from the rows of A^T, one per rotor. Each of the four directions is scaled to length
  /// 1 first.
  /// @param more  text appended to error messages
  static std::vector<double> of(const std::vector<double>& rows, const std::string& robot,
                                const std::string& mode, const std::string& more = "") {
    static const char* const kNames[4] = {"thrust along z", "roll torque", "pitch torque",
                                          "yaw torque"};
    const std::size_t n = rows.size() / 4;
    double scale[4], m[4][8] = {};
    for (std::size_t k = 0; k < 4; ++k) {
      double sum = 0.0;
      for (std::size_t i = 0; i < n; ++i) sum += rows[4 * i + k] * rows[4 * i + k];
      if (!(sum > 1e-18)) refuse_direction(robot, mode, kNames[k], more);
      scale[k] = 1.0 / sqrt(sum);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t l = 0; l < 4; ++l) {
        for (std::size_t i = 0; i < n; ++i) {
          m[k][l] += (rows[4 * i + k] * scale[k]) * (rows[4 * i + l] * scale[l]);
        }
      }
      m[k][4 + k] = 1.0;
    }
    for (int k = 0; k < 4; ++k) {
      if (!eliminate(m, k)) refuse_direction(robot, mode, kNames[k], more);
    }
    std::vector<double> inverse(rows.size());
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t l = 0; l < 4; ++l) {
        double sum = 0.0;
        for (std::size_t k = 0; k < 4; ++k) sum += (rows[4 * i + k] * scale[k]) * m[k][4 + l];
        inverse[4 * i + l] = sum * scale[l];
      }
    }
    return inverse;
  }

 private:
  /// One column of Gauss-Jordan elimination with partial pivoting; false if the pivot vanishes.
  static bool eliminate(double (&m)[4][8], int k) {
    int best = k;
    for (int r = k + 1; r < 4; ++r) {
      if (abs(m[r][k]) > abs(m[best][k])) best = r;
    }
    if (!(abs(m[best][k]) > 1e-9)) return false;
    for (int c = 0; c < 8; ++c) {
      const double swap = m[k][c];
      m[k][c] = m[best][c];
      m[best][c] = swap;
    }
    const double pivot = m[k][k];
    for (int c = 0; c < 8; ++c) m[k][c] /= pivot;
    for (int r = 0; r < 4; ++r) {
      if (r == k) continue;
      const double factor = m[r][k];
      for (int c = 0; c < 8; ++c) m[r][c] -= factor * m[k][c];
    }
    return true;
  }

  [[noreturn]] static void refuse_direction(const std::string& robot, const std::string& mode,
                                            const std::string& what, const std::string& more) {
    refuse("the rotors of robot `", robot, "` cannot give ", what, " independently, which ", mode,
           " needs: check position, axis, direction and moment_constant in its rotors file, or use "
           "controller `srt`",
           more);
  }
};

}  // namespace skybody::control
