#include "core/physics/hand_over_dynamics.h"

#include <vector>

#include "core/base/error.h"
#include "core/physics/reach.h"
#include "core/physics/tree_dynamics.h"

namespace skybody {
namespace {

class HandOverDynamics final : public Dynamics {
 public:
  explicit HandOverDynamics(const World& world)
      : world_(world),
        reach_(world),
        swept_(reach_.sphere_count()),
        tree_(make_tree_dynamics(world)) {}

  void begin_step(const BodyKinematics<double>* motion) override {
    is_on_simbody_ = reach_.is_possible() && reach_.is_within(motion, swept_.data());
  }

  bool is_on_simbody() const override { return is_on_simbody_; }

  void set_params(const double* params) override {
    if (is_on_simbody_ && !simbody_) simbody_ = make_simbody_dynamics(world_, params);
    chosen().set_params(params);
  }

  void accelerations(const double* q, const double* u, const SpatialForce<double>* body_forces,
                     const double* joint_forces, double* udot) override {
    chosen().accelerations(q, u, body_forces, joint_forces, udot);
  }

  void add_contacts(const double* q, const double* u, std::vector<Contact>& out) override {
    chosen().add_contacts(q, u, out);
  }

  void body_states(const double* q, const double* u, BodyState* bodies) override {
    chosen().body_states(q, u, bodies);
  }

 private:
  Dynamics& chosen() {
    if (!is_on_simbody_) return *tree_;
    SKYBODY_DEMAND(simbody_ != nullptr, "begin_step without set_params");
    return *simbody_;
  }

  const World& world_;
  Reach reach_;
  std::vector<SweptSphere<double>> swept_;
  std::unique_ptr<Dynamics> tree_;
  std::unique_ptr<Dynamics> simbody_;  ///< null: never needed so far
  bool is_on_simbody_ = false;
};

}  // namespace

std::unique_ptr<Dynamics> make_hand_over_dynamics(const World& world) {
  return std::make_unique<HandOverDynamics>(world);
}

}  // namespace skybody
