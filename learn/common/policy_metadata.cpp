#include "learn/common/policy_metadata.h"

#include "core/base/math/hash.h"

namespace skybody::learn {

PolicyFile policy_metadata(const CompiledScenario& compiled, const std::string& algorithm,
                           std::int64_t steps) {
  PolicyFile file;
  file.scenario = compiled.scenario().name;
  file.scenario_hash = to_hex(compiled.scenario().hash);
  file.algorithm = algorithm;
  file.steps = steps;
  file.observation_size = compiled.observation_size();
  file.action_size = compiled.action_size();
  return file;
}

void set_normalization(const RunningMoments& moments, double clip, PolicyFile& file) {
  file.clip = clip;
  for (std::size_t k = 0; k < static_cast<std::size_t>(file.input_size()); ++k) {
    file.mean.push_back(moments.mean[k]);
    file.scale.push_back(moments.scale(k));
  }
}

}  // namespace skybody::learn
