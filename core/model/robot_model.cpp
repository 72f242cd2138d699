#include "core/model/robot_model.h"

namespace skybody {

int position_size(JointType type) {
  switch (type) {
    case JointType::kWeld:
      return 0;
    case JointType::kFree:
      return 7;
    case JointType::kPin:
    case JointType::kSlider:
      return 1;
    case JointType::kUniversal:
      return 2;
    case JointType::kBall:
      return 4;
  }
  return 0;
}

int velocity_size(JointType type) {
  switch (type) {
    case JointType::kWeld:
      return 0;
    case JointType::kFree:
      return 6;
    case JointType::kPin:
    case JointType::kSlider:
      return 1;
    case JointType::kUniversal:
      return 2;
    case JointType::kBall:
      return 3;
  }
  return 0;
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
