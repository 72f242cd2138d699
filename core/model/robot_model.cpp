#include "core/model/robot_model.h"

namespace skybody {

int joint_constant_count(const Joint& joint) {
  switch (joint.type) {
    case JointType::kWeld:
    case JointType::kFree:
      return 0;
    case JointType::kUniversal:
    case JointType::kBall:
      return kJointStiffness;
    case JointType::kPin:
    case JointType::kSlider:
      return joint.limit.enabled ? kJointParamCount : kLimitStiffness;
  }
  return 0;
}

std::array<double, kBodyParamCount> body_constants(const MassProperties& mass) {
  const Vec3<double>& c = mass.com;
  const SymMat3<double>& i = mass.inertia;
  return {mass.mass, c.x, c.y, c.z, i.xx, i.yy, i.zz, i.xy, i.xz, i.yz};
}

MassProperties mass_properties(const double* constants) {
  const double *c = constants + kCom, *i = constants + kInertia;
  return {constants[kMass], {c[0], c[1], c[2]}, {i[0], i[1], i[2], i[3], i[4], i[5]}};
}

Shape contact_shape(const Shape& shape) {
  if (shape.type != ShapeType::kMesh) return shape;
  Shape box;
  box.type = ShapeType::kBox;
  box.size = shape.box_size;
  box.pose = shape.pose;
  box.pose.position += rotate(shape.pose.rotation, shape.box_center);
  return box;
}

double RobotModel::total_mass() const {
  double sum = 0.0;
  for (const Body& body : bodies) sum += body.mass.mass;
  return sum;
}

int RobotModel::find_link(const std::string& link_name) const {
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].name == link_name) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace skybody
