// User code outside the source tree: load a scenario, step it, read states.
#include <skybody/skybody.h>

#include <cstdio>
#include <vector>

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  skybody::Simulation simulation({.scenario = argv[1], .seed = 3});
  simulation.reset();
  const std::vector<float> action(static_cast<std::size_t>(simulation.action_size()), 0.2f);
  for (int i = 0; i < 100 && !simulation.done(); ++i) simulation.step(action);
  const skybody::BodyState& base = simulation.bodies()[0];
  std::printf("t = %.3f s, z = %.6f m, %d observed values, hash %016llx\n", simulation.time(),
              base.position.z, simulation.observation_size(),
              static_cast<unsigned long long>(simulation.hash()));
  return simulation.steps() == 100 ? 0 : 1;
}
