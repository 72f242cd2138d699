#include "core/physics/bodies/joint_reactions.h"

namespace skybody {

void joint_reactions(const World& world, const double* params, const BodyKinematics<double>* motion,
                     const BodyAcceleration* accelerations, const SpatialForce<double>* loads,
                     SpatialForce<double>* out) {
  joint_reactions_of(world, params, motion, accelerations, loads, out);
}

}  // namespace skybody
