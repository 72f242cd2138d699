// Source: COLLADA 1.4.1, Khronos Group 2008, chapter 5. <lookat> is the inverse of OpenGL's
// gluLookAt(): the node's -z axis points at the target. <skew> is rejected: the specification does
// not define its angle precisely, and programs differ.
#include "core/io/urdf/mesh_dae_transform.h"

#include "core/base/math/quat.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

constexpr double kDegree = kPi / 180.0;

Vec3<double> vector_at(const std::vector<double>& n, std::size_t k) {
  return {n[k], n[k + 1], n[k + 2]};
}

/// The unit vector. Rejects zero vectors, and vectors whose squares overflow.
Vec3<double> direction(const Vec3<double>& v, const XMLElement& element) {
  const double length = norm(v);
  if (length > 0.0 && is_finite(v / length)) return v / length;
  refuse_element(element, "<" + std::string(element.Name()) + "> has an axis without a direction");
}

DaeTransform matrix(const XMLElement& element) {
  const std::vector<double> n = dae_numbers(element, 16);
  if (n[12] != 0.0 || n[13] != 0.0 || n[14] != 0.0 || n[15] != 1.0) {
    refuse_element(element, "the last row of <matrix> is not 0 0 0 1");
  }
  return {{{n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10]}}, {n[3], n[7], n[11]}};
}

DaeTransform rotation(const XMLElement& element) {
  const std::vector<double> n = dae_numbers(element, 4);
  DaeTransform result;
  if (n[3] == 0.0) return result;  // exporters write arbitrary axes for a zero angle
  const Vec3<double> axis = direction(vector_at(n, 0), element);
  result.linear = to_mat3(from_axis_angle(axis, n[3] * kDegree));
  return result;
}

DaeTransform scaling(const XMLElement& element) {
  const std::vector<double> n = dae_numbers(element, 3);
  DaeTransform result;
  for (int k = 0; k < 3; ++k) result.linear(k, k) = n[static_cast<std::size_t>(k)];
  return result;
}

DaeTransform look(const XMLElement& element) {
  const std::vector<double> n = dae_numbers(element, 9);
  const Vec3<double> eye = vector_at(n, 0), forward = direction(vector_at(n, 3) - eye, element);
  const Vec3<double> right = direction(cross(forward, vector_at(n, 6)), element);
  const Vec3<double> up = cross(right, forward);
  return {{{right.x, up.x, -forward.x, right.y, up.y, -forward.y, right.z, up.z, -forward.z}}, eye};
}

}  // namespace

DaeTransform read_dae_transform(const XMLElement& element) {
  const std::string kind = element.Name();
  if (kind == "matrix") return matrix(element);
  if (kind == "rotate") return rotation(element);
  if (kind == "translate") {
    return {Mat3<double>::identity(), vector_at(dae_numbers(element, 3), 0)};
  }
  if (kind == "scale") return scaling(element);
  if (kind == "lookat") return look(element);
  if (kind == "skew") refuse_element(element, "<skew> is not read; write it as a <matrix>");
  return {};
}

}  // namespace skybody
