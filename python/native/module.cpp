#include "python/native/bindings.h"
#include "python/native/numpy_array.h"

namespace skybody::python {

NB_MODULE(_native, m) {
  m.doc() = "Skybody's engine. Use it through the package `skybody`.";
  import_numpy();
  bind_errors(m);
  bind_settings(m);
  bind_shapes(m);
  bind_compiled_scenario(m);
  bind_batch(m);
  bind_differentiable_envs(m);
  bind_info_columns(m);
  bind_learn(m);
  bind_policy(m);
  bind_pool(m);
  bind_ppo(m);
  bind_render(m);
  bind_simulation(m);
  bind_flight_policy(m);
  bind_mission(m);
  bind_policy_network(m);
  bind_simulation_pool(m);
  bind_versions(m);
}

}  // namespace skybody::python
