// Probe of SkybodySimbody.cmake at configure time: was the library built with or without NDEBUG?
//
// Inline functions of SimTK::State access objects that the library creates; these are larger
// without NDEBUG. Compiled with NDEBUG against a library built without it, this program crashes.
// Compiled without NDEBUG, it needs functions that only a library built without NDEBUG has, and
// otherwise does not link.
#undef NDEBUG
#if SKYBODY_PROBE_NDEBUG
#define NDEBUG
#endif
#include <Simbody.h>

namespace {

// Never called, but linked: refers to the functions that only one kind of library has.
bool is_valid(const SimTK::State& state) {
  return state.isCacheValueRealized(SimTK::SubsystemIndex(0), SimTK::CacheEntryIndex(0));
}

}  // namespace

int main(int argc, char**) {
  using SimTK::Vec3;
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter(system);
  SimTK::GeneralForceSubsystem forces(system);
  forces.setNumberOfThreads(1);
  SimTK::Force::Gravity gravity(forces, matter, Vec3(0, 0, -10));
  SimTK::Body::Rigid body(SimTK::MassProperties(2.0, Vec3(0), SimTK::Inertia(1.0)));
  SimTK::MobilizedBody::Free free_body(matter.updGround(), SimTK::Transform(), body,
                                       SimTK::Transform());
  SimTK::State state = system.realizeTopology();
  if (argc > 1) return is_valid(state) ? 0 : 1;
  SimTK::Vector rate;
  for (int step = 0; step < 100; ++step) {
    system.realize(state, SimTK::Stage::Acceleration);
    state.updU() += 0.01 * state.getUDot();
    system.realize(state, SimTK::Stage::Position);
    matter.multiplyByN(state, false, state.getU(), rate);
    state.updQ() += 0.01 * rate;
    matter.normalizeQuaternions(state);
  }
  system.realize(state, SimTK::Stage::Velocity);
  const Vec3 velocity = free_body.getBodyOriginVelocity(state);
  return (velocity - Vec3(0, 0, -10)).norm() < 1e-9 ? 0 : 1;
}
