#include "core/physics/coupling/coupling_response.h"

#include "core/base/simd/kernel_width.h"
#include "core/physics/coupling/coupling_equations.h"

namespace skybody {
namespace {

/// The computation of one call.
template <class Real>
class CouplingResponse {
 public:
  SKYBODY_INLINE explicit CouplingResponse(const CouplingResponseCall<Real>& call)
      : call_(call), w_(call.work), count_(static_cast<int>(call.scene.row_owners.size())) {}

  SKYBODY_INLINE void find() const {
    prepare();
#pragma GCC unroll 1
    for (int s = 0; s < count_; ++s) {
      const CouplingConstraint& constraint = constraint_of(s);
      push(constraint, w_.rows[s]);
      Real* change = w_.change + s * call_.scene.world.layout.u.size;
      for (int e = 0; e < 2; ++e) {
        const int robot = constraint.ends[static_cast<std::size_t>(e)].robot;
        if (robot < 0 || (e == 1 && robot == constraint.ends[0].robot)) continue;
        call_.multibody.respond(robot, w_.at_rest, w_.bodies, w_.nothing, w_.forces, w_.multibody,
                                change);
      }
      for (int r = s; r < count_; ++r) w_.equations.mass[r * count_ + s] = rate_of(r, constraint);
      const Real mobility = mobility_of(constraint.ends[0]) + mobility_of(constraint.ends[1]);
      w_.equations.least_pivot[s] = least_pivot_of(w_.equations.mass[s * count_ + s], mobility);
      for (const Attachment& end : constraint.ends) {
        if (end.body >= 0) w_.forces[end.body] = SpatialForce<Real>::zero();
      }
    }
  }

 private:
  const CouplingConstraint& constraint_of(int row) const {
    const CouplingScene& scene = call_.scene;
    return scene
        .constraints[static_cast<std::size_t>(scene.row_owners[static_cast<std::size_t>(row)])];
  }

  SKYBODY_INLINE void prepare() const {
    const SpatialForce<Real> none = SpatialForce<Real>::zero();
    int r = -1;
    for (const RobotLayout& robot : call_.scene.world.layout.robots) {
      if (!call_.scene.is_held(++r)) continue;
      for (int i = robot.first_body; i < robot.first_body + robot.body_count; ++i) {
        w_.at_rest[i] = call_.motion[i];
        w_.at_rest[i].velocity = w_.at_rest[i].angular_velocity = w_.at_rest[i].spin = none.force;
        w_.forces[i] = none;
      }
      call_.multibody.prepare(r, call_.q, w_.at_rest, w_.bodies, w_.nothing, w_.forces,
                              w_.multibody);
    }
  }

  /// Applies a unit force along the row, and its reaction.
  SKYBODY_INLINE void push(const CouplingConstraint& constraint,
                           const CouplingRow<Real>& row) const {
    const int first = constraint.ends[0].body, second = constraint.ends[1].body;
    if (first >= 0) w_.forces[first].add_force_at(row.arm[0], row.out);
    if (second >= 0) w_.forces[second].add_force_at(row.arm[1], -row.out);
  }

  /// Effect of the force of `constraint` on the rate of a row.
  SKYBODY_INLINE Real rate_of(int row, const CouplingConstraint& constraint) const {
    const CouplingConstraint& mine = constraint_of(row);
    Real sum(0.0);
    for (int e = 0; e < 2; ++e) {
      const Attachment& end = mine.ends[static_cast<std::size_t>(e)];
      const bool is_moved = end.robot >= 0 && (end.robot == constraint.ends[0].robot ||
                                               end.robot == constraint.ends[1].robot);
      if (!is_moved) continue;
      const SpatialAcceleration<Real>& a = w_.multibody.acceleration[end.body];
      const Real along = dot(w_.rows[row].out, a.linear + cross(a.angular, w_.rows[row].arm[e]));
      sum = e == 0 ? sum + along : sum - along;
    }
    return sum;
  }

  /// Mobility of an end for a unit force, if its body were free. An upper bound over all
  /// directions: the rotational part is the sum over three directions.
  SKYBODY_INLINE Real mobility_of(const Attachment& end) const {
    if (end.body < 0) return Real(0.0);
    const Real* body = w_.bodies + kBodyConstantCount * end.body;
    const SymMat3<Real> inverse = load_sym_mat3(body + kBodyInverseInertia);
    const Vec3<Real> arm = to_real<Real>(end.point) - load_vec3(body + kBodyCom);
    const Real turning =
        ((inverse.xx + inverse.yy) + inverse.zz) * dot(arm, arm) - dot(arm, inverse * arm);
    return body[kBodyInverseMass] + turning;
  }

  const CouplingResponseCall<Real>& call_;
  const CouplingWorkspace<Real>& w_;
  int count_;
};

struct Respond {
  template <int W>
  static SKYBODY_INLINE void run(const void* call) {
    using Real = RealOf<W>;
    CouplingResponse<Real>(*static_cast<const CouplingResponseCall<Real>*>(call)).find();
  }
};

}  // namespace

CouplingResponseFunction* coupling_response_function(int lanes) {
  return width_function<Respond>(lanes);
}

}  // namespace skybody
