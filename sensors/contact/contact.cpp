// Contact: force and moment on a body by whatever touches it.
#include "sensors/common/errors.h"
#include "sensors/common/mount.h"
#include "sensors/common/settings.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

class ContactSensor : public sensor::TimedSensor {
 public:
  void configure(const Setup& setup) override {
    mount_.configure(setup);
    choose_partner(setup);
    configure_timing(setup, {.size = 7, .may_leave_out = true});
    setup.channel("force", "N", 3, -kInfinity, kInfinity, mount_.robot());
    setup.channel("moment", "N m", 3, -kInfinity, kInfinity, mount_.robot());
    setup.channel("touching", "", 1, 0.0, 1.0, mount_.robot());
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output,
             Values<Real> buffer) const {
    const auto is_due = due(env, buffer);
    const Values<Real> sample = room(env, output);
    if (any(is_due)) measure(env, sample);
    deliver(env, is_due, sample, output, buffer);
  }

 private:
  /// `partner`: anything, the ground, an obstacle, or a link as ROBOT.LINK.
  void choose_partner(const Setup& setup) {
    const std::string& name = partner_.value();
    if (name == "any") {
      setup.need_contacts();
    } else if (name == "ground") {
      pair_ = setup.contact_pair(mount_.body(), Partner::kGroundPlane);
    } else if (const int obstacle = obstacle_called(setup, name); obstacle >= 0) {
      pair_ = setup.contact_pair(mount_.body(), Partner::kObstacle, obstacle);
    } else {
      pair_ = setup.contact_pair(mount_.body(), Partner::kBody, body_called(setup, name));
    }
  }
  static int obstacle_called(const Setup& setup, const std::string& name) {
    for (const ShapeInfo& shape : setup.shapes()) {
      if (shape.obstacle >= 0 && name == shape.name) return shape.obstacle;
    }
    return -1;
  }
  int body_called(const Setup& setup, const std::string& name) const {
    const std::size_t dot = name.find('.');
    if (dot == std::string::npos) {
      refuse("`partner` is `", name,
             "`, which is no obstacle; allowed: any, ground, the name of an "
             "obstacle, or ROBOT.LINK");
    }
    const int robot = setup.robot(name.substr(0, dot));
    const int body = setup.link(robot, name.substr(dot + 1)).body;
    if (body != mount_.body()) return body;
    refuse("`partner` is `", name,
           "`, which belongs to the body of the sensor itself: name another");
  }

  template <class Real>
  SKYBODY_INLINE void measure(const EnvView<Real>& env, const Values<Real>& sample) const {
    const ContactSum<Real> sum = pair_ < 0 ? env.contact(mount_.body()) : env.contact_pair(pair_);
    const Quat<Real> rotation = env.body(mount_.body()).rotation;
    const Vec3<Real> arm = rotate(rotation, mount_.point(env));
    const Quat<Real> axes = rotation * mount_.rotation(env);
    Vec3<Real> force = rotate_inverse(axes, sum.force);
    Vec3<Real> moment = rotate_inverse(axes, sum.moment - cross(arm, sum.force));
    if (force_noise_.is_given() || moment_noise_.is_given()) {
      Real draws[6];
      sensor::fill_normal(random(env), draws);
      force = sensor::with_noise(force, force_noise_(env), sensor::vec3_of(draws, 0));
      moment = sensor::with_noise(moment, moment_noise_(env), sensor::vec3_of(draws, 3));
    }
    const auto feels =
        logical_and(sum.touching, squared_norm(sum.force) >= square(threshold_(env)));
    sample.set(0, force);
    sample.set(3, moment);
    sample.set(6, select(feels, Real(1.0), Real(0.0)));
  }

  sensor::Mount mount_{this};
  TextParameter partner_{
      this, word("partner", "any", "contacts with: any, ground, an obstacle, or ROBOT.LINK")};
  RealParameter threshold_{
      this, sensor::error_size("threshold", "N", "least force that counts as touching")};
  RealParameter force_noise_{this,
                             sensor::error_size("force_noise", "N", "standard deviation per axis")};
  RealParameter moment_noise_{
      this, sensor::error_size("moment_noise", "N m", "standard deviation per axis")};
  int pair_ = -1;  ///< for EnvView::contact_pair(); -1: all contacts
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::ContactSensor, "contact", "1.0.0",
               "Force [N], moment [N m] and touch of the contacts of a body.");
