// Bullet's btDiscreteDynamicsWorld::stepSimulation, one world with R quadrotors on one core.
//
// The fastest documented settings for this work: empty shapes in no collision group, an empty
// pair cache, the faster broad phase for that number of bodies, one step per call without
// interpolation, no motion states, the explicit gyroscopic term (as in our semi-implicit Euler),
// single precision (Bullet's own default).
#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <btBulletDynamicsCommon.h>

#include <memory>

#include "research/peers/step_bench.h"

namespace skybody::bench {
namespace {

constexpr int kFewBodies = 2;  ///< up to here btSimpleBroadphase is quicker than btDbvtBroadphase

std::unique_ptr<btBroadphaseInterface> make_broadphase(int robots, btOverlappingPairCache* pairs) {
  if (robots <= kFewBodies) return std::make_unique<btSimpleBroadphase>(kFewBodies, pairs);
  return std::make_unique<btDbvtBroadphase>(pairs);
}

btVector3 vector(const double* values) {
  return {static_cast<btScalar>(values[0]), static_cast<btScalar>(values[1]),
          static_cast<btScalar>(values[2])};
}

class BulletWorld {
 public:
  explicit BulletWorld(int robots) : broadphase_(make_broadphase(robots, &pairs_)) {
    world_.setGravity({0, 0, static_cast<btScalar>(-kQuadrotor.g)});
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(kQuadrotor.mass), nullptr,
                                                  &shape_, vector(kQuadrotor.inertia));
    for (int robot = 0; robot < robots; ++robot) {
      bodies_.push_back(std::make_unique<btRigidBody>(info));
      bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
      bodies_.back()->setFlags(BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT);
      world_.addRigidBody(bodies_.back().get(), 0, 0);
    }
  }
  ~BulletWorld() {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  void start() {
    for (std::size_t robot = 0; robot < bodies_.size(); ++robot) {
      const double place = kQuadrotor.spacing * static_cast<double>(robot);
      const double position[3] = {place, place, kQuadrotor.height};
      bodies_[robot]->setCenterOfMassTransform(
          btTransform(btQuaternion::getIdentity(), vector(position)));
      bodies_[robot]->setLinearVelocity({0, 0, 0});
      bodies_[robot]->setAngularVelocity({0, 0, 0});
    }
  }

  void step(const double* thrusts, double* states) {
    for (const auto& body : bodies_) {
      const Wrench wrench = rotor_wrench(thrusts);
      const btMatrix3x3& axes = body->getWorldTransform().getBasis();
      body->applyCentralForce(axes.getColumn(2) * static_cast<btScalar>(wrench.thrust));
      body->applyTorque(axes * vector(wrench.moment));
      thrusts += 4;
    }
    world_.stepSimulation(static_cast<btScalar>(kQuadrotor.dt), 0);
    for (const auto& body : bodies_) {
      write(*body, states);
      states += kStates;
    }
  }

 private:
  static void write(const btRigidBody& body, double* states) {
    const btTransform& pose = body.getWorldTransform();
    const btQuaternion turn = pose.getRotation();
    std::copy_n(&pose.getOrigin()[0], 3, states);
    states[3] = turn.w();
    std::copy_n(&turn[0], 3, states + 4);
    std::copy_n(&body.getLinearVelocity()[0], 3, states + 7);
    std::copy_n(&body.getAngularVelocity()[0], 3, states + 10);
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btNullPairCache pairs_;
  std::unique_ptr<btBroadphaseInterface> broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, broadphase_.get(), &solver_, &configuration_};
  btEmptyShape shape_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

int run(int count, char** words) {
  const Effort effort = parse(count, words);
  const std::string version =
      std::to_string(BT_BULLET_VERSION / 100) + "." + std::to_string(BT_BULLET_VERSION % 100);
  const std::string engine = "Bullet " + version;
  const Peer peer{"bullet_cpp", version.c_str(), engine.c_str(),
                  "float32; no contact; no rotor lag; thrusts as commands; no observation, reward "
                  "or ends"};
  for (const int robots : effort.robots()) {
    BulletWorld world(robots);
    print_row(peer, "stepSimulation", world, robots, effort);
  }
  return 0;
}

}  // namespace
}  // namespace skybody::bench

int main(int count, char** words) { return skybody::bench::run(count, words); }
