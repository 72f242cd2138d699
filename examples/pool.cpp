// Flies 64 quadrotors to a height of 1.5 m: a batch on two threads, state values by path, and a
// control law in Eigen for all environments at once. Usage: example_pool [SCENARIO]
#include <skybody/eigen.h>
#include <skybody/skybody.h>

#include <cmath>
#include <cstdio>

int main(int argc, char** argv) {
  const auto compiled = skybody::compile_scenario({argc > 1 ? argv[1] : "hover", {}, {}});
  skybody::Pool envs(compiled, {.envs = 64, .threads = 2, .seed = 1});
  envs.send_reset();
  auto batch = envs.recv();

  skybody::RowMatrix<double> position(envs.envs(), 3), velocity(envs.envs(), 3);
  skybody::RowMatrix<float> actions(envs.envs(), compiled->action_size());
  for (int step = 0; step < 4000; ++step) {
    envs.state("robots.quad.base.position", skybody::values_of(position));  // W [m]
    envs.state("robots.quad.base.velocity", skybody::values_of(velocity));  // W [m/s]
    const Eigen::VectorXd command =
        0.21 + 0.2 * (1.5 - position.col(2).array()) - 0.2 * velocity.col(2).array();
    actions.colwise() = command.cast<float>();  // the same for all rotors: no tilt
    envs.send(skybody::values_of(actions));
    batch = envs.recv();
  }

  const double error = (position.col(2).array() - 1.5).abs().mean();
  std::printf("after %.1f s: mean height error %.3f m, mean reward %.3f, %lld observed values\n",
              4000 * compiled->scenario().stepping.dt, error, skybody::rewards(*batch).mean(),
              static_cast<long long>(skybody::observations(*batch).cols()));
  return error < 0.1 ? 0 : 1;
}
