#include "learn/common/policy_metadata.h"

#include "core/base/math/hash.h"

namespace skybody::learn {

PolicyFile policy_metadata(const CompiledScenario& compiled, Algorithm algorithm,
                           std::int64_t steps) {
  PolicyFile file;
  file.scenario = compiled.scenario().name;
  file.scenario_hash = to_hex(compiled.scenario().hash);
  file.algorithm = name(algorithm);
  file.steps = steps;
  file.observation_size = compiled.observation_size();
  file.action_size = compiled.action_size();
  return file;
}

}  // namespace skybody::learn
