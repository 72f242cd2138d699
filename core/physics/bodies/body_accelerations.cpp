#include "core/physics/bodies/body_accelerations.h"

namespace skybody {

void body_accelerations(const std::vector<TreeBody>& tree, const double* q, const double* u,
                        const double* udot, const BodyKinematics<double>* motion,
                        BodyAcceleration* out) {
  body_accelerations(tree, 0, static_cast<int>(tree.size()), q, u, udot, motion, out);
}

std::vector<BodyAcceleration> body_accelerations(const std::vector<TreeBody>& tree, const double* q,
                                                 const double* u, const double* udot) {
  std::vector<BodyKinematics<double>> motion(tree.size());
  std::vector<BodyAcceleration> out(tree.size());
  forward_kinematics(tree, q, u, motion.data());
  body_accelerations(tree, q, u, udot, motion.data(), out.data());
  return out;
}

}  // namespace skybody
