#include "core/physics/forces/contact.h"

#include "core/base/math.h"
#include "core/physics/forces/ground_contact.h"

namespace skybody {

void add_ground_contacts(const World& world, const double* constants, const double* bodies,
                         int stride, std::vector<Contact>& out) {
  for (const ContactSphere& sphere : world.spheres) {
    BodyState body;
    auto* values = reinterpret_cast<double*>(&body);
    for (int k = 0; k < 13; ++k) values[k] = bodies[(13 * sphere.body + k) * stride];
    const Mat3<double> axes = to_mat3(body.rotation);
    Vec3<double> arm = axes * sphere.center;
    arm.z -= sphere.radius;
    const Vec3<double> point = body.position + arm;
    if (!(point.z < 0.0)) continue;
    const Vec3<double> velocity = body.velocity + cross(axes * body.angular_velocity, arm);
    const Vec3<double> force =
        ground_force(constants, point, velocity, sphere.stiffness, sphere.most_damping);
    out.push_back({sphere.body, kGround, point, {0.0, 0.0, 1.0}, -point.z, force});
  }
}

}  // namespace skybody
