#include "learn/gradient/goal_cost.h"

#include "core/base/math/quat.h"
#include "core/base/simd/kernels.h"
#include "core/physics/step/free_robot_adjoint.h"
#include "core/physics/world/lane_values.h"

namespace skybody::learn {
namespace {

template <class Real>
SKYBODY_INLINE void add_to(double* row, const Real& x, const MaskOf<Real>& mask) {
  store_lanes(row, load_lanes<Real>(row) + x, mask);
}

constexpr double kSoftness = 0.01;  // [m^2/s^2]
constexpr double kNearWeight = 0.3, kYawWeight = 0.5, kRateWeight = 0.02;

struct AddGoalCost {
  template <int W>
  static SKYBODY_INLINE void run(const GoalCost& c, std::uint32_t lanes, double weight,
                                 const double* motion, const double* goal, double* adjoints,
                                 double* cost, double* distance) {
    for (int l = 0; l < kGroupLanes; l += W) {
      const std::uint32_t bits = (lanes >> l) & ((1u << W) - 1u);
      if (bits != 0) {
        add<Pack<W>>(c, mask_from_bits<Pack<W>>(bits), weight, motion + l, goal + l, adjoints + l,
                     cost + l, distance + l);
      }
    }
  }

  template <class Real>
  static SKYBODY_INLINE void add(const GoalCost& c, const MaskOf<Real>& mask, double weight,
                                 const double* motion, const double* goal, double* to, double* cost,
                                 double* distance) {
    const auto row = [](auto* p, int k) SKYBODY_INLINE_LAMBDA { return p + k * kGroupLanes; };
    const LaneValues<Real> m(motion), g(goal);
    const Vec3<Real> e = Vec3<Real>{g[0], g[1], g[2]} - Vec3<Real>{m[0], m[1], m[2]};
    const Real d = norm(e) + 1e-6;
    const Vec3<Real> toward = e * (1.0 / d);
    const auto is_close = d * c.approach_rate < c.approach_speed;
    const Real speed = select(is_close, d * c.approach_rate, Real(c.approach_speed));
    const Vec3<Real> w{m[10], m[11], m[12]}, point = to_real<Real>(c.point);
    const Quat<Real> q{m[3], m[4], m[5], m[6]};
    Vec3<Real> velocity{m[7], m[8], m[9]};
    if (c.has_point()) velocity += rotate(q, cross(w, point));
    const Vec3<Real> v = velocity - Vec3<Real>{g[4], g[5], g[6]} - toward * speed;
    const Real root = sqrt(squared_norm(v) + kSoftness);
    const Vec3<Real> to_v = v * (weight / root);
    // v_g turns with the direction to the goal; close to the goal it also shrinks.
    const Real along = dot(toward, to_v), turn = speed / d;
    const Vec3<Real> far = (to_v - toward * along) * turn;
    const Vec3<Real> near = to_v * Real(c.approach_rate);
    const Vec3<Real> to_e = toward * select(d < 1.0, Real(kNearWeight * weight), Real(0.0)) -
                            select(is_close, near, far);
    const Real y = 2.0 * (q.x * q.y + q.w * q.z), x = 1.0 - 2.0 * (q.y * q.y + q.z * q.z);
    const Real yaw_error = wrap_angle(atan2(y, x) - g[3]);
    const Real slope = (2.0 * kYawWeight * weight) * yaw_error / max(x * x + y * y, Real(1e-3));
    const Real to_y = slope * x, to_x = -(slope * y);
    add_to(row(to, 0), -to_e.x, mask);
    add_to(row(to, 1), -to_e.y, mask);
    add_to(row(to, 2), -to_e.z, mask);
    add_to(row(to, 3), 2.0 * (q.z * to_y), mask);
    add_to(row(to, 4), 2.0 * (q.y * to_y), mask);
    add_to(row(to, 5), 2.0 * (q.x * to_y) - 4.0 * (q.y * to_x), mask);
    add_to(row(to, 6), 2.0 * (q.w * to_y) - 4.0 * (q.z * to_x), mask);
    add_to(row(to, 7), to_v.x, mask);
    add_to(row(to, 8), to_v.y, mask);
    add_to(row(to, 9), to_v.z, mask);
    for (int k = 0; k < 3; ++k) {
      add_to(row(to, 10 + k), (2.0 * kRateWeight * weight) * m[10 + k], mask);
    }
    const Real sum = root + kNearWeight * min(d, Real(1.0)) + kYawWeight * yaw_error * yaw_error +
                     kRateWeight * squared_norm(w);
    if (c.has_point()) add_lever(q, w, point, -to_e, to_v, mask, to);
    add_to(cost, weight * sum, mask);
    store_lanes(distance, d, mask);
  }

  /// Contribution of the point's position and velocity to the derivatives by the body's rotation
  /// and rates:
  ///   p = origin + R point, v = velocity + R (w x point).
  template <class Real>
  static SKYBODY_INLINE void add_lever(const Quat<Real>& q, const Vec3<Real>& w,
                                       const Vec3<Real>& point, const Vec3<Real>& to_p,
                                       const Vec3<Real>& to_v, const MaskOf<Real>& mask,
                                       double* to) {
    const Vec3<Real> turning = cross(w, point);
    const Quat<Real> to_q = pull_back_axes(q, outer(to_p, point) + outer(to_v, turning));
    const Vec3<Real> to_w = cross(point, transpose_times(to_mat3(q), to_v));
    const Real values[] = {to_q.w, to_q.x, to_q.y, to_q.z};
    const Real rates[] = {to_w.x, to_w.y, to_w.z};
    for (int k = 0; k < 4; ++k) add_to(to + (3 + k) * kGroupLanes, values[k], mask);
    for (int k = 0; k < 3; ++k) add_to(to + (10 + k) * kGroupLanes, rates[k], mask);
  }
  template <class Real>
  static SKYBODY_INLINE Mat3<Real> outer(const Vec3<Real>& a, const Vec3<Real>& b) {
    return {{a.x * b.x, a.x * b.y, a.x * b.z, a.y * b.x, a.y * b.y, a.y * b.z, a.z * b.x, a.z * b.y,
             a.z * b.z}};
  }
};

}  // namespace

void GoalCost::add(std::uint32_t lanes, double weight, const double* motion, const double* goal,
                   double* adjoints, double* cost, double* distance, Isa isa) const {
  kernel<AddGoalCost>(isa)(*this, lanes, weight, motion, goal, adjoints, cost, distance);
}

}  // namespace skybody::learn
