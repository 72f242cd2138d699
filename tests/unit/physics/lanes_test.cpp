// Kinematics and forces written for `Real`: packs give the same bits as one environment at a time.
#include <gtest/gtest.h>

#include <cstring>

#include "core/physics/forces/base_drive.h"
#include "core/physics/forces/force_model.h"
#include "tests/unit/physics/test_models.h"

namespace skybody::test {
namespace {

constexpr int kLanes = 4;
using EnvView = Pack<kLanes>;

/// The values of kLanes environments, interleaved as packs.
std::vector<EnvView> interleave(const std::vector<std::vector<double>>& rows) {
  std::vector<EnvView> out(rows[0].size());
  for (std::size_t k = 0; k < out.size(); ++k) {
    for (int lane = 0; lane < kLanes; ++lane) out[k].v[lane] = rows[lane][k];
  }
  return out;
}

void expect_same_bits(const EnvView& pack, int lane, double value, const char* what) {
  const double in_lane = pack.v[lane];
  EXPECT_EQ(std::memcmp(&in_lane, &value, sizeof(double)), 0)
      << what << ", lane " << lane << ": " << in_lane << " and " << value;
}
void expect_same_bits(const Vec3<EnvView>& pack, int lane, const Vec3<double>& v,
                      const char* what) {
  expect_same_bits(pack.x, lane, v.x, what);
  expect_same_bits(pack.y, lane, v.y, what);
  expect_same_bits(pack.z, lane, v.z, what);
}

/// A vehicle with every kind of force, at the ground, with a chain of all joints.
struct BusyWorld {
  BusyWorld()
      : world(make_world(make(), [](WorldPlan& plan) {
          plan.sites = {{0, {0.1, 0, 0}, true, false}, {1, {0, 0, 0}, false, true}};
        })) {}

  static Scenario make() {
    RobotModel model = make_vehicle(qdrone2());
    for (Rotor& rotor : model.rotors) {
      rotor.constants[kDragConstant] = 2e-5;
      rotor.constants[kRollingMomentConstant] = 1e-6;
      rotor.constants[kRotorInertia] = 5e-6;
    }
    const JointType types[] = {JointType::kPin, JointType::kUniversal, JointType::kBall,
                               JointType::kSlider, JointType::kWeld};
    const char* names[] = {"pin", "universal", "ball", "slider", "weld"};
    for (int i = 0; i < 5; ++i) {
      Body body = make_body(names[i], types[i], i, 0.3, {0.03, -0.02, -0.1},
                            diagonal(0.002, 0.0025, 0.003));
      body.joint.frame_in_parent = {{0.1, 0.05, -0.2}, from_rpy(0.3, 0.1, -0.5)};
      body.joint.frame_in_body = {{-0.02, 0.04, 0.06}, from_rpy(-0.6, 0.2, 0.4)};
      body.joint.constants[kJointDamping] = 0.01;
      body.joint.constants[kJointStiffness] = 2.0;
      body.joint.limit = {true, -0.2, 0.2};
      body.joint.constants[kLimitStiffness] = 50.0;
      body.joint.constants[kLimitDamping] = 0.1;
      body.collisions = {make_sphere(0.05)};
      model.bodies.push_back(body);
    }
    Scenario scenario = make_scenario(model);
    scenario.robots[0].constants = {1, 2, 3, 0.1, 0.2, 0.3};
    return scenario;
  }

  const World world;
};

class Random {
 public:
  double next() {
    word_ = word_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(word_ >> 11) * 0x1p-52 - 1.0;
  }
  std::vector<std::vector<double>> rows(std::size_t size, double scale, double offset = 0.0) {
    std::vector<std::vector<double>> out(kLanes, std::vector<double>(size));
    for (auto& row : out) {
      for (double& value : row) value = offset + scale * next();
    }
    return out;
  }

 private:
  std::uint64_t word_ = 12345;
};

/// Motion and forces of one environment, or of a pack of them.
template <class Real>
struct Evaluation {
  Evaluation(const World& world, const std::vector<Real>& q, const std::vector<Real>& u,
             const std::vector<Real>& params, const std::vector<Real>& wrench,
             const std::vector<Real>& speed, const std::vector<Real>& command)
      : bodies(world.bodies.size()),
        forces(world.bodies.size()),
        joint_forces(u.size(), Real(0.0)),
        rates(q.size()) {
    const std::vector<TreeBody> tree = make_tree(world);
    forward_kinematics(tree, q.data(), u.data(), bodies.data());
    for (const TreeBody& b : tree) {
      position_rates(b.type, q.data() + b.q, u.data() + b.u, rates.data() + b.q);
    }
    for (std::size_t i = 0; i < speed.size(); ++i) {
      const Real* constants = params.data() + world.layout.rotor_params[i];
      const RotorLag<Real> lag = make_rotor_lag(constants, 0.001);
      rotors.push_back(
          rotor_at(lag, speed[i], limit_command(command[i], constants[kMaxSpeed]), kStepMiddle));
    }
    const ForceInputs<Real> in{q.data(),      u.data(),      bodies.data(),
                               rotors.data(), params.data(), wrench.data()};
    ForceModel(world).evaluate(in, forces.data(), joint_forces.data());
  }
  std::vector<BodyKinematics<Real>> bodies;
  std::vector<SpatialForce<Real>> forces;
  std::vector<Real> joint_forces, rates;
  std::vector<RotorMotion<Real>> rotors;
};

TEST(EnvView, KinematicsAndForcesHaveTheBitsOfOneEnvironmentAtATime) {
  const BusyWorld busy;
  const World& world = busy.world;
  LaneState start;
  write_default_state(world, start);
  Random random;
  for (int round = 0; round < 50; ++round) {
    const auto q = random.rows(start.q.size(), 0.4), u = random.rows(start.u.size(), 2.0);
    const auto wrench = random.rows(start.wrench.size(), 3.0);
    const auto speed = random.rows(4, 500.0, 600.0), command = random.rows(4, 1500.0, 1000.0);
    const std::vector<std::vector<double>> params(kLanes, start.params);
    const Evaluation<EnvView> packed(world, interleave(q), interleave(u), interleave(params),
                                     interleave(wrench), interleave(speed), interleave(command));
    for (int lane = 0; lane < kLanes; ++lane) {
      const Evaluation<double> one(world, q[lane], u[lane], params[lane], wrench[lane], speed[lane],
                                   command[lane]);
      for (std::size_t i = 0; i < world.bodies.size(); ++i) {
        expect_same_bits(packed.bodies[i].position, lane, one.bodies[i].position, "position");
        expect_same_bits(packed.bodies[i].velocity, lane, one.bodies[i].velocity, "velocity");
        expect_same_bits(packed.forces[i].force, lane, one.forces[i].force, "force");
        expect_same_bits(packed.forces[i].moment, lane, one.forces[i].moment, "moment");
      }
      for (std::size_t i = 0; i < one.joint_forces.size(); ++i) {
        expect_same_bits(packed.joint_forces[i], lane, one.joint_forces[i], "joint force");
      }
      for (std::size_t i = 0; i < one.rates.size(); ++i) {
        expect_same_bits(packed.rates[i], lane, one.rates[i], "rate");
      }
      for (std::size_t i = 0; i < one.rotors.size(); ++i) {
        expect_same_bits(packed.rotors[i].speed, lane, one.rotors[i].speed, "rotor speed");
        expect_same_bits(packed.rotors[i].acceleration, lane, one.rotors[i].acceleration,
                         "spin-up");
      }
    }
  }
}

TEST(EnvView, DrivesHaveTheBitsOfOneEnvironmentAtATime) {
  Random random;
  const auto q = random.rows(7, 1.0), target = random.rows(7, 1.0);
  const std::vector<EnvView> packed_q = interleave(q), packed_target = interleave(target);
  std::vector<EnvView> packed_u(6);
  drive_to_pose(packed_q.data(), packed_target.data(), 0.001, packed_u.data());
  for (int lane = 0; lane < kLanes; ++lane) {
    double u[6];
    drive_to_pose(q[lane].data(), target[lane].data(), 0.001, u);
    for (int i = 0; i < 6; ++i) expect_same_bits(packed_u[i], lane, u[i], "u");
  }
}

}  // namespace
}  // namespace skybody::test
