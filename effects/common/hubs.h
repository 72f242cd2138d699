// Rotor hubs grouped by body, so that a body's attitude is read once for all of them.
#pragma once

#include <skybody/plugin.h>

#include <vector>

namespace skybody::effect {

/// A rotor on its body.
struct Hub {
  int rotor = 0;                ///< world index
  Vec3<double> position, axis;  ///< nominal [m]; unit vector in the direction of thrust; body axes
  int thrust_constant = 0;      ///< index of the thrust constant for EnvView::param()
  int place = 0;                ///< index of the position's x for EnvView::param(); y and z follow
};

/// A body with rotors.
struct Carrier {
  int robot = 0, body = 0;  ///< world indices
  std::vector<Hub> hubs;
};

/// The carriers of these robots, in the order of robots and of their rotors files.
inline std::vector<Carrier> carriers_of(const Setup& setup, const std::vector<int>& robots) {
  std::vector<Carrier> carriers;
  for (const int robot : robots) {
    const std::size_t first = carriers.size();
    for (const RotorInfo& rotor : setup.rotors_of(robot)) {
      std::size_t c = first;
      while (c < carriers.size() && carriers[c].body != rotor.body) ++c;
      if (c == carriers.size()) carriers.push_back({robot, rotor.body, {}});
      const double *p = rotor.position, *n = rotor.axis;
      carriers[c].hubs.push_back({static_cast<int>(&rotor - setup.rotors().begin()),
                                  {p[0], p[1], p[2]},
                                  {n[0], n[1], n[2]},
                                  rotor.first_param + SKYBODY_ROTOR_THRUST_CONSTANT,
                                  rotor.first_param + SKYBODY_ROTOR_POSITION});
    }
  }
  return carriers;
}

/// Calls visit(hub, height, upright) for each hub: height is its z in W [m], upright the cosine of
/// the angle between its axis and W's z.
template <class Real, class Visit>
SKYBODY_INLINE void each_hub(const std::vector<Carrier>& carriers, const EnvView<Real>& env,
                             Visit&& visit) {
  const Vec3<Real> z{Real(0.0), Real(0.0), Real(1.0)};
  for (const Carrier& carrier : carriers) {
    const BodyMotion<Real> body = env.body(carrier.body);
    const Vec3<Real> up = rotate_inverse(body.rotation, z);
    for (const Hub& hub : carrier.hubs) {
      const Real height = body.position.z + dot(up, env.param_vec3(hub.place));
      visit(hub, height, dot(up, to_real<Real>(hub.axis)));
    }
  }
}

}  // namespace skybody::effect
