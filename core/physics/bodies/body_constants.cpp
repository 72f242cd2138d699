#include "core/physics/bodies/body_constants.h"

#include "core/physics/bodies/checked_mass.h"

namespace skybody {
namespace {

void store(const SymMat3<double>& m, double* p) {
  const double values[6] = {m.xx, m.yy, m.zz, m.xy, m.xz, m.yz};
  for (int k = 0; k < 6; ++k) p[k] = values[k];
}

}  // namespace

void make_body_constants(const World& world, const double* params, double* out) {
  for (std::size_t i = 0; i < world.bodies.size(); ++i, out += kBodyConstantCount) {
    const MassProperties m =
        checked_mass(world.bodies[i].model->name, params + world.layout.body_params[i]);
    out[kBodyMass] = m.mass;
    skybody::store(m.com, out + kBodyCom);
    store(m.inertia, out + kBodyInertia);
    out[kBodyInverseMass] = 1.0 / m.mass;
    store(inverse(m.inertia), out + kBodyInverseInertia);
  }
}

}  // namespace skybody
