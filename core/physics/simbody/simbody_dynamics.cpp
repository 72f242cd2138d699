// Dynamics by Simbody. Forces do not go through Simbody's force subsystems. They are passed to its
// operator calcAccelerationIgnoringConstraints, which costs little more than half of
// realize(Acceleration) with Force::DiscreteForces and gives the same accelerations.
//
// Simbody's coordinates differ from those of this simulator (JointType) for two joints:
//   Free  q = quaternion, position   here: position, quaternion
//         u = angular velocity in F axes, velocity   here: velocity, angular velocity in M axes
//   Ball  u in F axes                here: in M axes
// With R = F from M: w_F = R w_M, and so dw_M/dt = R^T dw_F/dt exactly, since R^T (w_F x w_F) = 0.
// Generalised forces transform like velocities: power is the same in both axes.
//
// Compiled as C++17 and with the Simbody library's options (NDEBUG): see
// cmake/SkybodySimbody.cmake.
#include <Simbody.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <vector>

#include "core/base/system/error.h"
#include "core/physics/bodies/checked_mass.h"
#include "core/physics/bodies/kinematics.h"
#include "core/physics/coupling/coupling_scene.h"
#include "core/physics/simbody/dynamics.h"

namespace skybody {
namespace {

using SimTK::SpatialVec;

SimTK::Vec3 to_simbody(const Vec3<double>& v) { return {v.x, v.y, v.z}; }
SimTK::Transform to_simbody(const Pose& pose) {
  const Quat<double>& q = pose.rotation;
  return {SimTK::Rotation(SimTK::Quaternion(q.w, q.x, q.y, q.z)), to_simbody(pose.position)};
}
Vec3<double> from_simbody(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

/// Mass properties about the body's origin from one body's parameters.
/// @throws Error if they are not physical
SimTK::MassProperties make_mass(const std::string& name, const double* params) {
  const MassProperties mass = checked_mass(name, params);
  const SymMat3<double> o = mass.inertia + point_inertia(mass.mass, mass.com);
  return {mass.mass, to_simbody(mass.com), SimTK::Inertia(o.xx, o.yy, o.zz, o.xy, o.xz, o.yz)};
}

/// One body's coordinates in Simbody. The rotation comes first in Simbody, last in this simulator.
struct Slot {
  JointType type = JointType::kFree;
  int q = 0, u = 0;  ///< in this simulator
  int simbody_q = 0, simbody_u = 0;
  bool is_driven = false;
  Quat<double> rotation{1.0, 0.0, 0.0, 0.0};  ///< F from M at the current q, for Free and Ball

  bool turns() const { return type == JointType::kFree || type == JointType::kBall; }
  /// Number of coordinates, of `count`, that do not belong to the rotation.
  int plain(int count, int of_rotation) const { return turns() ? count - of_rotation : count; }

  void put_position(const double* ours, double* simbody) {
    const int first = plain(position_size(type), 4);
    if (turns()) {
      rotation = normalized(load_quat(ours + first));
      simbody = std::copy_n(ours + first, 4, simbody);
    }
    std::copy_n(ours, first, simbody);
  }
  void get_position(const double* simbody, double* ours) const {
    const int first = plain(position_size(type), 4);
    if (turns()) {
      std::copy_n(simbody, 4, ours + first);
      simbody += 4;
    }
    std::copy_n(simbody, first, ours);
  }
  /// Velocities, or generalised forces.
  void put_velocity(const double* ours, double* simbody) const {
    const int first = plain(velocity_size(type), 3);
    if (turns()) {
      store(rotate(rotation, load_vec3(ours + first)), simbody);
      simbody += 3;
    }
    std::copy_n(ours, first, simbody);
  }
  void get_velocity(const double* simbody, double* ours) const {
    const int first = plain(velocity_size(type), 3);
    if (turns()) {
      store(rotate_inverse(rotation, load_vec3(simbody)), ours + first);
      simbody += 3;
    }
    std::copy_n(simbody, first, ours);
  }
};

/// A Simbody system with its state. Built for one set of mass properties.
class SimbodySystem {
 public:
  SimbodySystem(const World& world, const std::vector<TreeBody>& tree, const double* params)
      : matter_(system_) {
    system_.setUseUniformBackground(true);  // no ground plane: there is no visualizer
    for (std::size_t i = 0; i < tree.size(); ++i) {
      SimTK::Body::Rigid body(
          make_mass(world.bodies[i].model->name, params + world.layout.body_params[i]));
      add_body(tree[i], body);
    }
    add_constraints(world, params);
    state_ = system_.realizeTopology();
    lock_driven_bases(world);
    system_.realize(state_, SimTK::Stage::Instance);
    make_slots(world, tree);
    body_forces_.resize(matter_.getNumBodies());
    body_forces_ = SpatialVec(SimTK::Vec3(0));
    mobility_forces_.resize(state_.getNU());
    mobility_forces_ = 0.0;
  }

  void accelerations(const double* q, const double* u, const SpatialForce<double>* body_forces,
                     const double* joint_forces, double* udot) {
    put_coordinates(q, u);
    system_.realize(state_, SimTK::Stage::Dynamics);
    put_forces(body_forces, joint_forces);
    matter_.calcAccelerationIgnoringConstraints(state_, mobility_forces_, body_forces_, udot_,
                                                body_accelerations_);
    get_accelerations(udot);
  }

  void hold(const bool* held) {
    bool changes = false;
    for (const auto& [coupling, constraint] : constraints_) {
      if (constraint.isDisabled(state_) != held[coupling]) continue;
      changes = true;
      if (held[coupling]) {
        constraint.enable(state_);
      } else {
        constraint.disable(state_);
      }
    }
    if (changes) system_.realize(state_, SimTK::Stage::Instance);
  }

  void constrained_accelerations(const double* q, const double* u,
                                 const SpatialForce<double>* body_forces,
                                 const double* joint_forces, double* udot) {
    put_coordinates(q, u);
    system_.realize(state_, SimTK::Stage::Dynamics);
    put_forces(body_forces, joint_forces);
    matter_.calcAcceleration(state_, mobility_forces_, body_forces_, udot_, body_accelerations_);
    get_accelerations(udot);
  }

  void project(double* q, double* u) {
    constexpr double kAccuracy = 1e-12;
    put_coordinates(q, u);
    system_.realize(state_, SimTK::Stage::Velocity);
    system_.projectQ(state_, kAccuracy);
    system_.projectU(state_, kAccuracy);
    for (Slot& slot : slots_) {
      if (slot.type == JointType::kWeld || slot.is_driven) continue;
      slot.get_position(&state_.getQ()[slot.simbody_q], q + slot.q);
      slot.put_position(q + slot.q, &state_.updQ()[slot.simbody_q]);  // its rotation
      slot.get_velocity(&state_.getU()[slot.simbody_u], u + slot.u);
    }
  }

  void body_states(const double* q, const double* u, BodyState* bodies) {
    put_coordinates(q, u);
    system_.realize(state_, SimTK::Stage::Velocity);
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      const SimTK::MobilizedBody& body = mobilized(i);
      const SimTK::Quaternion rotation = body.getBodyRotation(state_).convertRotationToQuaternion();
      bodies[i] = {
          from_simbody(body.getBodyOriginLocation(state_)),
          {rotation[0], rotation[1], rotation[2], rotation[3]},
          from_simbody(body.getBodyOriginVelocity(state_)),
          from_simbody(~body.getBodyRotation(state_) * body.getBodyAngularVelocity(state_))};
    }
  }

 private:
  /// Bodies are added in the world's order; index 0 is Simbody's ground.
  const SimTK::MobilizedBody& mobilized(std::size_t body) const {
    return matter_.getMobilizedBody(SimTK::MobilizedBodyIndex(static_cast<int>(body) + 1));
  }

  void add_body(const TreeBody& tree, const SimTK::Body& body) {
    SimTK::MobilizedBody& parent = updated(tree.parent);
    const SimTK::Transform f = to_simbody(tree.frame_in_parent);
    const SimTK::Transform m = to_simbody(tree.frame_in_body);
    switch (tree.type) {
      case JointType::kWeld:
        SimTK::MobilizedBody::Weld(parent, f, body, m);
        break;
      case JointType::kFree:
        SimTK::MobilizedBody::Free(parent, f, body, m);
        break;
      case JointType::kPin:
        SimTK::MobilizedBody::Pin(parent, f, body, m);
        break;
      case JointType::kSlider:
        SimTK::MobilizedBody::Slider(parent, f, body, m);
        break;
      case JointType::kUniversal:
        SimTK::MobilizedBody::Universal(parent, f, body, m);
        break;
      case JointType::kBall:
        SimTK::MobilizedBody::Ball(parent, f, body, m);
        break;
    }
  }

  /// Adds Simbody's constraints for couplings that are equations.
  void add_constraints(const World& world, const double* params) {
    const CouplingScene scene(world);
    for (std::size_t i = 0; i < scene.constraints.size(); ++i) {
      const CouplingConstraint& constraint = scene.constraints[i];
      if (constraint.row_count == 0) continue;
      SimTK::MobilizedBody& a = updated(constraint.ends[0].body);
      SimTK::MobilizedBody& b = updated(constraint.ends[1].body);
      const SimTK::Vec3 at = to_simbody(constraint.ends[0].point);
      const SimTK::Vec3 to = to_simbody(constraint.ends[1].point);
      if (constraint.kind == CouplingKind::kPoint) {
        constraints_.emplace_back(i, SimTK::Constraint::Ball(a, at, b, to));
      } else {
        const double length = params[constraint.params + kCouplingLength];
        constraints_.emplace_back(i, SimTK::Constraint::Rod(a, at, b, to, length));
      }
    }
  }
  SimTK::MobilizedBody& updated(int body) {
    return matter_.updMobilizedBody(SimTK::MobilizedBodyIndex(body + 1));
  }

  /// Prescribes zero acceleration to driven bases; their subtrees still move.
  void lock_driven_bases(const World& world) {
    for (std::size_t r = 0; r < world.drives.size(); ++r) {
      if (world.drives[r] == DriveKind::kNone) continue;
      mobilized(world.layout.robots[r].first_body).lock(state_, SimTK::Motion::Acceleration);
    }
  }

  void make_slots(const World& world, const std::vector<TreeBody>& tree) {
    std::vector<bool> is_driven(tree.size(), false);
    for (std::size_t r = 0; r < world.drives.size(); ++r) {
      const auto base = static_cast<std::size_t>(world.layout.robots[r].first_body);
      if (world.drives[r] != DriveKind::kNone) is_driven[base] = true;
    }
    for (std::size_t i = 0; i < tree.size(); ++i) {
      Slot slot;
      slot.type = tree[i].type;
      slot.q = tree[i].q;
      slot.u = tree[i].u;
      slot.is_driven = is_driven[i];
      if (slot.type != JointType::kWeld) {
        slot.simbody_q = static_cast<int>(mobilized(i).getFirstQIndex(state_));
        slot.simbody_u = static_cast<int>(mobilized(i).getFirstUIndex(state_));
      }
      slots_.push_back(slot);
    }
  }

  void put_coordinates(const double* q, const double* u) {
    if (slots_.empty() || state_.getNU() == 0) return;
    double* to_q = &state_.updQ()[0];
    double* to_u = &state_.updU()[0];
    for (Slot& slot : slots_) {
      slot.put_position(q + slot.q, to_q + slot.simbody_q);
      slot.put_velocity(u + slot.u, to_u + slot.simbody_u);
    }
  }

  void put_forces(const SpatialForce<double>* body_forces, const double* joint_forces) {
    static_assert(sizeof(SpatialForce<double>) == sizeof(SpatialVec), "moment, then force");
    std::memcpy(static_cast<void*>(&body_forces_[1]), body_forces,
                slots_.size() * sizeof(SpatialVec));
    if (mobility_forces_.size() == 0) return;
    double* to = &mobility_forces_[0];
    for (const Slot& slot : slots_) slot.put_velocity(joint_forces + slot.u, to + slot.simbody_u);
  }

  void get_accelerations(double* udot) const {
    if (udot_.size() == 0) return;
    const double* from = &udot_[0];
    for (const Slot& slot : slots_) slot.get_velocity(from + slot.simbody_u, udot + slot.u);
  }

  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::State state_;
  std::vector<std::pair<std::size_t, SimTK::Constraint>> constraints_;  ///< with the index of their
                                                                        ///< coupling
  std::vector<Slot> slots_;
  SimTK::Vector_<SpatialVec> body_forces_, body_accelerations_;
  SimTK::Vector mobility_forces_, udot_;
};

std::unique_ptr<SimbodySystem> make_system(const World& world, const std::vector<TreeBody>& tree,
                                           const double* params) {
  try {
    return std::make_unique<SimbodySystem>(world, tree, params);
  } catch (const SimTK::Exception::Base& error) {
    throw Error(std::string("Simbody cannot build the world: ") + error.what());
  }
}

/// Keeps a SimbodySystem for the current mass properties and rebuilds it when they change: in
/// Simbody they belong to the topology.
class SimbodyDynamics final : public Dynamics {
 public:
  SimbodyDynamics(const World& world, const double* params)
      : world_(world), tree_(make_tree(world)) {
    set_params(params);
  }

  void set_params(const double* params) override {
    if (world_.bodies.empty()) return;
    // The mass properties of all bodies are contiguous (world_layout.cpp).
    const double* masses = params + world_.layout.body_params.front();
    wanted_.assign(masses, masses + kBodyParamCount * world_.bodies.size());
    for (std::size_t i = 0; i < world_.scenario.couplings.size(); ++i) {
      const CouplingKind kind = world_.scenario.couplings[i].kind;
      if (kind != CouplingKind::kRod && kind != CouplingKind::kRope) continue;
      wanted_.push_back(params[world_.layout.coupling_params[i] + kCouplingLength]);
    }
    if (system_ != nullptr &&
        std::memcmp(wanted_.data(), built_from_.data(), wanted_.size() * sizeof(double)) == 0) {
      return;
    }
    system_.reset();
    system_ = make_system(world_, tree_, params);
    built_from_ = wanted_;
  }

  void accelerations(const double* q, const double* u, const SpatialForce<double>* body_forces,
                     const double* joint_forces, double* udot) override {
    guarded([&] { system_->accelerations(q, u, body_forces, joint_forces, udot); });
  }

  void hold(const bool* held) override {
    guarded([&] { system_->hold(held); });
  }

  void constrained_accelerations(const double* q, const double* u,
                                 const SpatialForce<double>* body_forces,
                                 const double* joint_forces, double* udot) override {
    guarded([&] { system_->constrained_accelerations(q, u, body_forces, joint_forces, udot); });
  }

  void project(double* q, double* u) override {
    guarded([&] { system_->project(q, u); });
  }

  void body_states(const double* q, const double* u, BodyState* bodies) override {
    if (system_ != nullptr) system_->body_states(q, u, bodies);
  }

 private:
  template <class Work>
  void guarded(const Work& work) {
    if (system_ == nullptr) return;
    try {
      work();
    } catch (const SimTK::Exception::Base& error) {
      system_.reset();  // its state is incomplete: the next step starts from a new system
      throw std::runtime_error(error.what());
    } catch (...) {
      system_.reset();
      throw;
    }
  }

  const World& world_;
  std::vector<TreeBody> tree_;
  /// Masses of all bodies and lengths of rods and ropes: of the built system, and of the last call.
  std::vector<double> built_from_, wanted_;
  std::unique_ptr<SimbodySystem> system_;
};

}  // namespace

void check_simbody(const World& world) {
  if (world.bodies.empty()) return;
  make_system(world, make_tree(world), world.layout.nominal_params().data());
}

std::unique_ptr<Dynamics> make_simbody_dynamics(const World& world, const double* params) {
  return std::make_unique<SimbodyDynamics>(world, params);
}

}  // namespace skybody
