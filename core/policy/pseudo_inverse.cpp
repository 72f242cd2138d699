#include "core/policy/pseudo_inverse.h"

#include <array>
#include <cmath>
#include <utility>

namespace skybody {
namespace {

using Matrix4 = std::array<std::array<double, 4>, 4>;

/// Gauss-Jordan with row pivoting. @returns false if singular
bool invert(Matrix4 a, Matrix4& inverse) {
  inverse = {};
  for (std::size_t i = 0; i < 4; ++i) inverse[i][i] = 1.0;
  double scale = 0.0;
  for (const auto& row : a) {
    for (const double x : row) scale = std::max(scale, std::abs(x));
  }
  for (std::size_t c = 0; c < 4; ++c) {
    std::size_t pivot = c;
    for (std::size_t r = c + 1; r < 4; ++r) {
      if (std::abs(a[r][c]) > std::abs(a[pivot][c])) pivot = r;
    }
    if (std::abs(a[pivot][c]) <= 1e-12 * scale) return false;
    std::swap(a[c], a[pivot]);
    std::swap(inverse[c], inverse[pivot]);
    const double d = a[c][c];
    for (std::size_t k = 0; k < 4; ++k) {
      a[c][k] /= d;
      inverse[c][k] /= d;
    }
    for (std::size_t r = 0; r < 4; ++r) {
      if (r == c) continue;
      const double f = a[r][c];
      for (std::size_t k = 0; k < 4; ++k) {
        a[r][k] -= f * a[c][k];
        inverse[r][k] -= f * inverse[c][k];
      }
    }
  }
  return true;
}

}  // namespace

std::vector<double> allocation_of(const World& world, int robot) {
  const RobotModel& model = world.scenario.robots[static_cast<std::size_t>(robot)].model;
  if (model.rotors.size() < 4) return {};
  std::vector<std::array<double, 4>> columns;  // what one newton of each rotor gives
  for (const Rotor& r : model.rotors) {
    if (r.body != 0) return {};
    const Vec3<double> arm = r.position - model.bodies[0].mass.com;
    const Vec3<double> torque =
        cross(arm, r.axis) -
        (r.direction * r.constants[kMomentConstant] / r.constants[kThrustConstant]) * r.axis;
    columns.push_back({r.axis.z, torque.x, torque.y, torque.z});
  }
  // Torques are a tenth of thrusts: scaled rows keep the singularity test meaningful.
  const double scale[4] = {1.0, 1.0 / 0.1, 1.0 / 0.1, 1.0 / 0.01};
  Matrix4 product{}, inverse;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (const auto& c : columns) product[i][j] += scale[i] * c[i] * c[j] * scale[j];
    }
  }
  if (!invert(product, inverse)) return {};
  std::vector<double> result;
  for (const auto& c : columns) {
    for (std::size_t j = 0; j < 4; ++j) {
      double sum = 0.0;
      for (std::size_t i = 0; i < 4; ++i) sum += scale[i] * c[i] * inverse[i][j];
      result.push_back(sum * scale[j]);
    }
  }
  return result;
}

double hanging_length(const World& world, int base, int body) {
  Vec3<double> position{0.0, 0.0, 0.0};
  for (int b = body; b != base && b >= 0; b = world.bodies[static_cast<std::size_t>(b)].parent) {
    const Joint& joint = world.bodies[static_cast<std::size_t>(b)].model->joint;
    const Quat<double> turn =
        joint.frame_in_parent.rotation * conjugate(joint.frame_in_body.rotation);
    position =
        joint.frame_in_parent.position + rotate(turn, position - joint.frame_in_body.position);
  }
  return position.z < 0.0 ? -position.z : 0.0;
}

}  // namespace skybody
