#include "core/physics/coupling/coupling_response.h"

#include "core/base/kernel_width.h"
#include "core/physics/coupling/coupling_equations.h"

namespace skybody {
namespace {

/// One call's work.
template <class Real>
class CouplingResponse {
 public:
  SKYBODY_INLINE explicit CouplingResponse(const CouplingResponseCall<Real>& call)
      : call_(call), w_(call.work), count_(static_cast<int>(call.scene.row_owners.size())) {}

  SKYBODY_INLINE void find() const {
    prepare();
#pragma GCC unroll 1
    for (int s = 0; s < count_; ++s) {
      const Joining& joining = joining_of(s);
      push(joining, w_.rows[s]);
      Real* change = w_.change + s * call_.scene.world.layout.u.size;
      for (int e = 0; e < 2; ++e) {
        const int robot = joining.ends[static_cast<std::size_t>(e)].robot;
        if (robot < 0 || (e == 1 && robot == joining.ends[0].robot)) continue;
        call_.forest.respond(robot, w_.at_rest, w_.bodies, w_.nothing, w_.forces, w_.forest,
                             change);
      }
      for (int r = s; r < count_; ++r) w_.mass[r * count_ + s] = rate_of(r, joining);
      const Real mobility = mobility_of(joining.ends[0]) + mobility_of(joining.ends[1]);
      w_.least_pivot[s] = least_pivot_of(w_.mass[s * count_ + s], mobility);
      for (const JoinedEnd& end : joining.ends) {
        if (end.body >= 0) w_.forces[end.body] = SpatialForce<Real>::zero();
      }
    }
  }

 private:
  const Joining& joining_of(int row) const {
    const CouplingScene& scene = call_.scene;
    return scene
        .joinings[static_cast<std::size_t>(scene.row_owners[static_cast<std::size_t>(row)])];
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
      call_.forest.prepare(r, call_.q, w_.at_rest, w_.bodies, w_.nothing, w_.forces, w_.forest);
    }
  }

  /// A unit force along the row, and its reaction.
  SKYBODY_INLINE void push(const Joining& joining, const CouplingRow<Real>& row) const {
    const int first = joining.ends[0].body, second = joining.ends[1].body;
    if (first >= 0) w_.forces[first].add_force_at(row.arm[0], row.out);
    if (second >= 0) w_.forces[second].add_force_at(row.arm[1], -row.out);
  }

  /// What the force of `joining` does to the rate of a row.
  SKYBODY_INLINE Real rate_of(int row, const Joining& joining) const {
    const Joining& mine = joining_of(row);
    Real sum(0.0);
    for (int e = 0; e < 2; ++e) {
      const JoinedEnd& end = mine.ends[static_cast<std::size_t>(e)];
      const bool is_moved = end.robot >= 0 && (end.robot == joining.ends[0].robot ||
                                               end.robot == joining.ends[1].robot);
      if (!is_moved) continue;
      const SpatialAcceleration<Real>& a = w_.forest.acceleration[end.body];
      const Real along = dot(w_.rows[row].out, a.linear + cross(a.angular, w_.rows[row].arm[e]));
      sum = e == 0 ? sum + along : sum - along;
    }
    return sum;
  }

  /// What a unit force at an end would do to it if its body were free; no direction has more: the
  /// part that turns the body is the sum over three directions.
  SKYBODY_INLINE Real mobility_of(const JoinedEnd& end) const {
    if (end.body < 0) return Real(0.0);
    const Real* body = w_.bodies + kBodyConstantCount * end.body;
    const SymMat3<Real> inverse = load_sym_mat3(body + kBodyInverseInertia);
    const Vec3<Real> arm = to_real<Real>(end.point) - load_vec3(body + kBodyCom);
    const Real turning =
        ((inverse.xx + inverse.yy) + inverse.zz) * dot(arm, arm) - dot(arm, inverse * arm);
    return body[kBodyInverseMass] + turning;
  }

  const CouplingResponseCall<Real>& call_;
  const CouplingWork<Real>& w_;
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
