// Forces on the base: all contacts, the ground only, and the joint of the second body.
#include <skybody/plugin.h>

namespace skybody {
namespace {

class FeelingSensor : public Sensor {
 public:
  void configure(const Setup& setup) override {
    setup.need_contacts();
    ground_ = setup.contact_pair(0, Partner::kGroundPlane);
    joint_ = setup.joint_reaction(setup.bodies().size() - 1);
    setup.channel("force", "N", 9, -kInfinity, kInfinity);
  }
  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output) const {
    const Vec3<Real> forces[] = {env.contact(0).force, env.contact_pair(ground_).force,
                                 env.joint_reaction(joint_).force};
    for (int k = 0; k < 3; ++k) output.set(3 * k, forces[k]);
  }

 private:
  int ground_ = 0, joint_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::FeelingSensor, "feeling_sensor", "1.0.0",
               "Contacts and a joint's reaction.");
