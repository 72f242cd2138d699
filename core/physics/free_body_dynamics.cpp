#include "core/physics/free_body_dynamics.h"

#include <cstring>
#include <vector>

#include "core/base/error.h"
#include "core/physics/checked_mass.h"
#include "core/physics/kinematics.h"

namespace skybody {
namespace {

class FreeBodyDynamics final : public Dynamics {
 public:
  explicit FreeBodyDynamics(const World& world)
      : name_(world.bodies.front().model->name),
        first_param_(world.layout.body_params.front()),
        is_driven_(world.drives.front() != DriveKind::kNone) {
    std::vector<double> nominal;
    for (const EnvParam& param : world.layout.param_info) nominal.push_back(param.nominal);
    set_params(nominal.data());
  }

  void set_params(const double* params) override {
    const double* mine = params + first_param_;
    if (has_mass_ && std::memcmp(mine, made_from_.data(), made_from_.size() * sizeof(double)) == 0)
      return;
    has_mass_ = false;
    const MassProperties mass = checked_mass(name_, mine);
    inverse_mass_ = 1.0 / mass.mass;
    com_ = mass.com;
    inertia_ = mass.inertia;
    inverse_inertia_ = inverse(mass.inertia);
    made_from_.assign(mine, mine + kBodyParamCount);
    has_mass_ = true;
  }

  void accelerations(const double* q, const double* u, const SpatialForce<double>* body_forces,
                     const double* joint_forces, double* udot) override {
    if (is_driven_) {
      for (int i = 0; i < 6; ++i) udot[i] = 0.0;
      return;
    }
    const Mat3<double> axes = to_mat3(normalized(load_quat(q + 3)));
    const Vec3<double> w = load_vec3(u + 3);
    const Vec3<double> force_w = body_forces->force + load_vec3(joint_forces);
    const Vec3<double> force = transpose_times(axes, force_w);
    const Vec3<double> moment =
        transpose_times(axes, body_forces->moment) + load_vec3(joint_forces + 3);

    const Vec3<double> about_com = moment - cross(com_, force);
    const Vec3<double> angular = inverse_inertia_ * (about_com - cross(w, inertia_ * w));
    const Vec3<double> com_from_origin = cross(angular, com_) + cross(w, cross(w, com_));
    store(force_w * inverse_mass_ - axes * com_from_origin, udot);
    store(angular, udot + 3);
  }

  void body_states(const double* q, const double* u, BodyState* bodies) override {
    bodies[0] = {load_vec3(q), normalized(load_quat(q + 3)), load_vec3(u), load_vec3(u + 3)};
  }

 private:
  std::string name_;
  int first_param_;
  bool is_driven_;

  bool has_mass_ = false;  ///< what follows belongs to `made_from_`
  std::vector<double> made_from_;
  double inverse_mass_;                        ///< [1/kg]
  Vec3<double> com_;                           ///< from the body's origin, body axes [m]
  SymMat3<double> inertia_, inverse_inertia_;  ///< about the centre of mass, body axes
};

}  // namespace

std::string why_not_tree(const World& world) {
  const std::vector<RobotUse>& robots = world.scenario.robots;
  if (robots.size() != 1) return "has " + std::to_string(robots.size()) + " robots";
  if (!world.scenario.obstacles.empty()) return "has obstacles";
  const std::string robot = "has the robot `" + robots.front().name + "` ";
  if (world.bodies.size() != 1) {
    return robot + "of " + std::to_string(world.bodies.size()) + " moving bodies";
  }
  if (world.bodies.front().model->joint.type != JointType::kFree) return robot + "on a fixed base";
  return "";
}

std::unique_ptr<Dynamics> make_free_body_dynamics(const World& world) {
  const std::string why_not = why_not_tree(world);
  SKYBODY_DEMAND(why_not.empty(), "the world " + why_not);
  return std::make_unique<FreeBodyDynamics>(world);
}

}  // namespace skybody
