// Contact in the environments of one Real: the pairs that may touch within a step, and the contact
// forces. On double and packs.
//
// Contact points of two shapes are points of one (corners, rims, centres) inside the other, and
// edges across each other. A force acts on both bodies at one point, so that momentum is conserved.
// Penetration is limited by `give`, a quarter of the thinner shape's width: motion beyond this
// limit is stopped plastically. A step is cut into substeps, each of which moves a shape by at most
// half of this limit.
#pragma once

#include "core/physics/contact/contact_bristles.h"
#include "core/physics/contact/contact_mobility.h"
#include "core/physics/contact/contact_pass.h"
#include "core/physics/contact/narrow_phase.h"
#include "core/physics/contact/normal_and_friction_law.h"

namespace skybody {

/// @tparam Values  access to constants: a pointer, or a view (lane_values.h)
template <class Real, class Values>
class ContactForces : public NarrowPhase<Real, Values> {
  using Search = NarrowPhase<Real, Values>;

 public:
  using Motion = BodyKinematics<Real>;

  /// @param constants  the world's kWorldParamCount values
  /// @param bodies     kBodyConstantCount values per body; read by act() only
  /// @param obstacles  kShapeConstantCount values per obstacle
  SKYBODY_INLINE ContactForces(const ContactScene& scene, const Values& constants,
                               const Real* bodies, const Values& obstacles,
                               const ContactWorkspace<Real>& work)
      : Search(scene, obstacles, work),
        mobility_{bodies},
        friction_(constants[kFriction]),
        dissipation_(constants[kDissipation]) {}

  /// Lanes with contacts so fast or so deep that velocities at a substep's start and its mean
  /// differ noticeably. Valid after act().
  SKYBODY_INLINE const MaskOf<Real>& is_quick() const { return is_quick_; }
  /// Lanes with springs too stiff for the shortest substeps. Valid after act() with mean
  /// velocities.
  SKYBODY_INLINE const MaskOf<Real>& is_stiff() const { return is_stiff_; }

  /// Lanes whose springs have no losses: there errors of a step accumulate.
  SKYBODY_INLINE MaskOf<Real> is_lossless() const { return dissipation_ <= 0.0; }

  /// For lossless springs, cuts the step as finely for all pairs of search() as if they began to
  /// touch with four points at once. A contact at a step's start or end, but not in its middle,
  /// where forces are evaluated, would gain or lose the energy of its spring.
  SKYBODY_INLINE void cut_lossless() {
    const MaskOf<Real> lossless = is_lossless();
    if (none(lossless)) return;
    for (int i = 0; i < near_count_; ++i) {
      const CandidatePair<Real>& near = w_.near[i];
      const CollisionPair& pair = *near.pair;
      Real speed = w_.bounds[pair.body].speed;
      if (pair.other >= 0) speed += w_.bounds[pair.other].speed;
      const Real rigidity = pair.law.stiffness * sqrt(dt() * speed);
      const Real phase = dt() * sqrt(1.5 * (rigidity * inverse_mass(pair)));
      ask_for(phase * (1.0 / kLosslessPhase), logical_and(lossless, near.lanes));
    }
  }

  /// Starts the step, or restarts it: clears all contact flags. The result of a lane must not
  /// depend on a restart that another lane causes.
  SKYBODY_INLINE void begin() {
    is_quick_ = MaskOf<Real>(false);
    for (std::size_t i = 0; i < scene_.world.bodies.size(); ++i) {
      w_.is_touched[i] = MaskOf<Real>(false);
      w_.place_counts[i] = Real(0.0);
    }
  }

  /// Computes the forces of the pairs found by search(), into ContactWorkspace::forces.
  /// @param motion     in the middle of the substep; velocities at its start
  /// @param mean       the same with mean velocities of the substep, if known
  /// @param step       duration of the substep [s]
  /// @param is_active  lanes to compute
  /// @param pass       after the first pass, contact points of the last call are reused
  /// @param list       list(pair, point, ContactKinematics, force, lanes): called for each contact
  template <class List = NoContactList>
  SKYBODY_INLINE void act(const Motion* motion, const Motion* mean, const Real& step,
                          const MaskOf<Real>& is_active, ContactPass pass, const List& list = {}) {
    const Vec3<Real> zero = SpatialForce<Real>::zero().force;
    for (std::size_t i = 0; i < scene_.world.bodies.size(); ++i) {
      w_.forces[i] = {zero, zero};
      if (may_stop_) w_.kicks[i] = {zero, zero};
    }
    bristles().each_busy([&](int i) SKYBODY_INLINE_LAMBDA { w_.is_bent[i] = MaskOf<Real>(false); });
    const Part part{motion, mean, step, pass};
    if (pass == ContactPass::kStart) {
      is_stiff_ = MaskOf<Real>(false);
      forget_places();
    }
    begin_sums(pass);
#pragma GCC unroll 1
    for (const Visit visit : {Visit::kSum, Visit::kTouch}) {
      if (visit == Visit::kSum && pass == ContactPass::kMean) continue;
      each_place(motion, is_active, [&](const ContactPoint<Real>& place) SKYBODY_INLINE_LAMBDA {
        if (visit == Visit::kTouch) {
          touch(part, place, list);
        } else if (pass == ContactPass::kStart) {
          count_place(place);
        } else {
          add_up(part, place);
        }
      });
      if (visit == Visit::kSum && pass == ContactPass::kStart) share_masses(step);
    }
  }

  /// The bristles of the pairs that search() found.
  SKYBODY_INLINE ContactBristles<Real> bristles() const { return {scene_, w_}; }

 private:
  /// Maximum phase of a lossless spring's oscillation per substep [rad].
  static constexpr double kLosslessPhase = 1.0 / 16.0;

  using Search::are_few;
  using Search::ask_for;
  using Search::dt;
  using Search::each_place;
  using Search::forget_places;
  using Search::may_stop_;
  using Search::near_count_;
  using Search::other_body;
  using Search::parts_;
  using Search::scene_;
  using Search::w_;

  /// Purpose of a loop over the contact points.
  enum class Visit {
    kSum,    ///< sums over the contact points of each body
    kTouch,  ///< forces
  };

  /// Values common to all contacts of a substep.
  struct Part {
    const Motion *motion, *mean;
    const Real& step;
    ContactPass pass;
  };

  /// Raises the number of substeps for contacts that are fast or deep, so that in each substep
  /// - the phase of the spring's oscillation is at most kLargestPhase (less for lossless springs),
  /// - the damping is at most ContactKinematics::most_damping,
  /// - the motion is small where the contact is going to be stopped.
  /// @param elastic  k x^1.5 [N]
  /// @param speed    magnitude of the rate of the depth
  SKYBODY_INLINE void ask_for_parts(const CandidatePair<Real>& near, const Real& depth,
                                    const Real& elastic, const Real& speed,
                                    const MaskOf<Real>& touches) {
    constexpr double kLargestPhase = 0.5, kStoppedParts = 24.0, kQuickWay = 0.05, kDeepPhase = 1.0,
                     kDeepDamping = 0.5;
    const Real way = dt() * speed;
    const double rest = scene_.world.scenario.contact.penetration;
    const Real kick = (1.5 * dt()) * (elastic * near.per_mass);  // 1.5 h k x^1.5 / m'
    const MaskOf<Real> lossless = is_lossless();
    const auto is_deep = logical_or(dissipation_ * kick > kDeepDamping,
                                    dt() * kick > kDeepPhase * kDeepPhase * depth);
    const auto is_quick =
        logical_and(touches, logical_or(way > kQuickWay * rest, logical_or(is_deep, lossless)));
    if (none(is_quick)) return;
    is_quick_ |= is_quick;
    const double stiffness = near.pair->law.stiffness;
    const Real reach = depth + way, rigidity = stiffness * sqrt(reach);
    const Real phase = dt() * sqrt(1.5 * (rigidity * near.per_mass));
    const Real damping = 1.5 * dissipation_ * (rigidity * reach);
    const Real most = select(lossless, Real(1.0 / kLosslessPhase), Real(1.0 / kLargestPhase));
    Real parts = max(phase * most, dt() * (damping * near.per_mass));
    if (!near.pair->is_unbounded_below) {
      // One spring alone cannot stop the whole body: 0.4 k x^2.5 < m v^2 / 2.
      const Real& give = near.give;
      const Real held = (0.8 * stiffness) * ((give * give) * sqrt(give));
      const auto is_stopped = speed * speed > held * whole_inverse_mass(*near.pair);
      parts = select(is_stopped, max(parts, way * kStoppedParts / give), parts);
    }
    ask_for(parts, is_quick);
  }

  /// ---- contact points

  /// Clears the sums for a pass.
  SKYBODY_INLINE void begin_sums(ContactPass pass) const {
    if (pass == ContactPass::kMean) return;
    Real* const sums = pass == ContactPass::kStart ? w_.place_counts : w_.sums;
    for (const ContactBody& body : scene_.bodies) sums[body.body] = Real(0.0);
  }

  SKYBODY_INLINE void count_place(const ContactPoint<Real>& place) const {
    if (are_few()) return;
    const CollisionPair& pair = *w_.near[place.pair].pair;
    const Real one = select(place.touches, Real(1.0), Real(0.0));
    w_.place_counts[scene_.bodies[static_cast<std::size_t>(pair.body)].body] += one;
    if (pair.other >= 0) w_.place_counts[other_body(pair).body] += one;
  }

  /// Computes, from the counts, the mass per contact point of each near pair, and the limit of
  /// damping.
  SKYBODY_INLINE void share_masses(const Real& step) const {
    for (int i = 0; i < near_count_; ++i) {
      CandidatePair<Real>& near = w_.near[i];
      if (!near.touches) continue;
      near.per_mass = inverse_mass(*near.pair);
      near.most_damping = 1.0 / max(near.per_mass * step, Real(1e-12));
    }
  }

  /// ---- contact forces

  template <class List>
  SKYBODY_INLINE void touch(const Part& part, const ContactPoint<Real>& place, const List& list) {
    const Vec3<Real>&point = place.point, &out = place.out;
    const MaskOf<Real>& touches = place.touches;
    const CandidatePair<Real>& near = w_.near[place.pair];
    const CollisionPair& pair = *near.pair;
    const int body = scene_.bodies[static_cast<std::size_t>(pair.body)].body;
    const int other = pair.other >= 0 ? other_body(pair).body : -1;
    const Vec3<Real> velocity = velocity_at(part.motion, body, other, point);
    const Real elastic = pair.law.stiffness * pow_3_2(max(place.depth, Real(0.0)));
    ContactKinematics<Real> t{place.depth,          out,       velocity,
                              velocity * part.step, part.step, near.most_damping};
    if (part.pass == ContactPass::kStart) {
      ask_for_parts(near, place.depth, elastic, abs(dot(out, velocity)), touches);
    } else {
      t.velocity = velocity_at(part.mean, body, other, point);
    }
    if (part.pass == ContactPass::kMean) find_stiff(t, elastic * near.per_mass, touches);
    if (part.pass == ContactPass::kLimited) t.velocity = select(is_stiff_, velocity, t.velocity);
    Real push = normal_force(t, elastic, dissipation_);
    if (part.pass == ContactPass::kLimited) {
      const Real sum = other >= 0 ? max(w_.sums[body], w_.sums[other]) : w_.sums[body];
      push = select(is_stiff_, limited_force(t, elastic, dissipation_, sum), push);
    }
    if (!pair.is_unbounded_below) stop(near, part, point, t, other, touches, push);
    const Real most = friction_ * push;
    const Vec3<Real> zero = SpatialForce<Real>::zero().force;
    Vec3<Real> force = out * push + friction(part, place, t, most);
    force = select(touches, force, zero);
    add(body, part.motion, point, force);
    if (other >= 0) add(other, part.motion, point, -force);
    w_.is_touched[body] |= touches;
    if (other >= 0) w_.is_touched[other] |= touches;
    list(pair, point, t, force, touches);
  }

  /// Finds lanes in which even the shortest substep is too long for a spring. Two conditions:
  /// - its damper alone would reverse the velocity of the contact point's share of the mass,
  /// - in half of the substep the velocity in fact changes by more than half of its difference from
  ///   1 / d. It changes less if the body carries much more than its own mass.
  /// @param rate  k x^1.5 / m' [m/s^2]
  SKYBODY_INLINE void find_stiff(const ContactKinematics<Real>& t, const Real& rate,
                                 const MaskOf<Real>& touches) {
    const auto is_shortest = parts_ > 0.75 * kMaxContactSubsteps;
    const Real d = 1.5 * dissipation_;
    const auto may = logical_and(touches, logical_and(is_shortest, d * rate * t.step > 1.0));
    if (none(may)) return;
    const Real start = dot(t.normal, t.slide) / t.step;
    const Real change = dot(t.normal, t.velocity) - start;  // of half a substep
    is_stiff_ |= logical_and(may, d * abs(change) > 0.5 * (1.0 - d * start));
  }

  /// Sums, for each body, the argument of limited_force().
  SKYBODY_INLINE void add_up(const Part& part, const ContactPoint<Real>& place) const {
    const CollisionPair& pair = *w_.near[place.pair].pair;
    const ContactBody& body = scene_.bodies[static_cast<std::size_t>(pair.body)];
    const Real gives = gives_at(pair, part.motion, place.point, place.out);
    const Real elastic = pair.law.stiffness * pow_3_2(max(place.depth, Real(0.0)));
    const Real sum = (1.5 * dissipation_) * (part.step * elastic * gives);
    const Real more = select(place.touches, sum, Real(0.0));
    w_.sums[body.body] += more;
    if (pair.other >= 0) w_.sums[other_body(pair).body] += more;
  }

  SKYBODY_INLINE Vec3<Real> friction(const Part& part, const ContactPoint<Real>& place,
                                     const ContactKinematics<Real>& t, const Real& most) const {
    const int bristle = place.bristle;
    if (bristle < 0) return viscous_friction(part, place, t, most);
    const ContactLaw& law = w_.near[place.pair].pair->law;
    MaskOf<Real>& is_bent = w_.is_bent[bristle];
    if (w_.is_idle[bristle]) is_bent = MaskOf<Real>(false);
    w_.is_idle[bristle] = false;
    Vec3<Real> bent = w_.bristles[bristle];
    const auto is_first = logical_and(place.touches, logical_not(is_bent));
    const Vec3<Real> force = bristle_force(t, law, most, bent);
    w_.bent[bristle] = select(is_first, bent, w_.bent[bristle]);
    const auto is_second = logical_and(place.touches, is_bent);
    is_bent |= place.touches;
    if (none(is_second)) return force;
    return select(is_second, viscous_friction(part, place, t, most), force);
  }

  /// Friction without a bristle. Its damping is 1 / n of the value that would stop the contact
  /// point within the substep, from its mobility along its own velocity. n is the number of contact
  /// points of the body (at least four), so that all of them together gain no energy.
  SKYBODY_INLINE Vec3<Real> viscous_friction(const Part& part, const ContactPoint<Real>& place,
                                             const ContactKinematics<Real>& t,
                                             const Real& most) const {
    const Vec3<Real> velocity = across(t.normal, t.velocity);
    const Real speed = norm(velocity);
    const Vec3<Real> along = velocity * (1.0 / max(speed, Real(1e-300)));
    const CollisionPair& pair = *w_.near[place.pair].pair;
    const auto shared = [&](const ContactBody& body) SKYBODY_INLINE_LAMBDA {
      return mobility_.gives_at(body, part.motion, place.point, along) * places_of(body);
    };
    Real gives = shared(scene_.bodies[static_cast<std::size_t>(pair.body)]);
    if (pair.other >= 0) gives += shared(other_body(pair));
    const Real damping = min(t.most_damping, 1.0 / max(gives * t.step, Real(1e-300)));
    return viscous_friction_force(velocity, speed, damping, most);
  }

  SKYBODY_INLINE void add(int body, const Motion* motion, const Vec3<Real>& point,
                          const Vec3<Real>& force) const {
    w_.forces[body].add_force_at(point - motion[body].position, force);
  }

  /// Velocity of the body's contact point relative to the other.
  static SKYBODY_INLINE Vec3<Real> velocity_at(const Motion* motion, int body, int other,
                                               const Vec3<Real>& point) {
    const auto of = [&](int i) SKYBODY_INLINE_LAMBDA {
      const Motion& m = motion[i];
      return m.velocity + cross(m.angular_velocity, point - m.position);
    };
    return other < 0 ? of(body) : of(body) - of(other);
  }

  /// Number of contact points of a body, at least kLeastPlaces.
  SKYBODY_INLINE Real places_of(const ContactBody& body) const {
    return max(w_.place_counts[body.body], Real(kLeastPlaces));
  }

  /// Inverse of the mass per contact point: each body's mass is shared by its contact points.
  SKYBODY_INLINE Real inverse_mass(const CollisionPair& pair) const {
    const auto of = [&](const ContactBody& body) SKYBODY_INLINE_LAMBDA {
      return mobility_.inverse_mass(body) * (places_of(body) * body.leverage);
    };
    const Real mine = of(scene_.bodies[static_cast<std::size_t>(pair.body)]);
    return pair.other < 0 ? mine : mine + of(other_body(pair));
  }
  /// Inverse mass of both bodies, each with its whole mass.
  SKYBODY_INLINE Real whole_inverse_mass(const CollisionPair& pair) const {
    const Real mine = mobility_.inverse_mass(scene_.bodies[static_cast<std::size_t>(pair.body)]);
    return pair.other < 0 ? mine : mine + mobility_.inverse_mass(other_body(pair));
  }

  SKYBODY_INLINE void kick(const ContactBody& body, const Motion* motion, const Vec3<Real>& point,
                           const Vec3<Real>& impulse) const {
    if (body.is_driven) return;
    const BodyVelocityChange<Real> change = mobility_.response(body, motion, point, impulse);
    w_.kicks[body.body].velocity += change.velocity;
    w_.kicks[body.body].angular_velocity += change.angular_velocity;
  }
  /// Mobility of a point of a pair: the sum over both bodies [1/kg].
  SKYBODY_INLINE Real gives_at(const CollisionPair& pair, const Motion* motion,
                               const Vec3<Real>& point, const Vec3<Real>& along) const {
    Real gives = mobility_.gives_at(scene_.bodies[static_cast<std::size_t>(pair.body)], motion,
                                    point, along);
    if (pair.other >= 0) gives += mobility_.gives_at(other_body(pair), motion, point, along);
    return gives;
  }

  /// Raises a push so that the contact point stays within the penetration limit, given all earlier
  /// stops of this substep. The stop is plastic.
  SKYBODY_INLINE void stop(const CandidatePair<Real>& near, const Part& part,
                           const Vec3<Real>& point, const ContactKinematics<Real>& t, int other,
                           const MaskOf<Real>& touches, Real& push) const {
    const CollisionPair& pair = *near.pair;
    const Real room = max(near.give - t.depth, Real(0.0));
    const auto is_quick = logical_and(touches, -dot(t.normal, t.slide) > room);
    if (none(is_quick)) return;
    const ContactBody& body = scene_.bodies[static_cast<std::size_t>(pair.body)];
    const auto of = [&](const ContactBody& one, Real& way, Real& gives) SKYBODY_INLINE_LAMBDA {
      if (one.is_driven) return;
      gives += mobility_.gives_at(one, part.motion, point, t.normal);
      way +=
          part.step * dot(t.normal, mobility_.moved(one, part.motion, point, w_.kicks[one.body]));
    };
    Real way = dot(t.normal, t.slide), of_other(0.0), gives(1e-12);
    of(body, way, gives);
    if (other >= 0) {
      of(other_body(pair), of_other, gives);
      way -= of_other;
    }
    const Real needed = max(-way - room, Real(0.0)) / (gives * part.step * part.step);
    push = select(is_quick, max(push, needed), push);
    const Vec3<Real> zero = SpatialForce<Real>::zero().force;
    const Vec3<Real> impulse = select(is_quick, t.normal * (push * part.step), zero);
    kick(body, part.motion, point, impulse);
    if (other >= 0) kick(other_body(pair), part.motion, point, -impulse);
  }

  ContactMobility<Real> mobility_;
  Real friction_, dissipation_;
  MaskOf<Real> is_quick_{false}, is_stiff_{false};
};

}  // namespace skybody
