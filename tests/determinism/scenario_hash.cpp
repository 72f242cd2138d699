// Prints the trajectory hash of each named scenario. build_types.sh compares the hashes of two
// builds.
#include <cstdio>
#include <vector>

#include "core/assemble/compile_scenario.h"
#include "core/base/math/hash.h"
#include "core/base/math/random.h"
#include "core/batch/pool.h"

namespace {

using namespace skybody;

constexpr int kEnvs = 9;  // one full block of lanes, and one environment left over
constexpr int kSteps = 300;

/// Actions span the whole allowed range.
std::uint64_t hash_of(const std::string& scenario) {
  LoadOptions options;
  options.scenario = scenario;
  Pool envs(compile_scenario(options), {.envs = kEnvs, .threads = 1, .seed = 7, .keep_hash = true});
  std::vector<float> actions(static_cast<std::size_t>(kEnvs * envs.compiled().action_size()));
  Random<double> random({7, 0}, 0, 0, derive_stream("hash.action"));
  envs.send_reset();
  envs.recv();
  for (int k = 0; k < kSteps; ++k) {
    for (float& value : actions) value = static_cast<float>(random.uniform(-1.0, 1.0));
    envs.send(actions);
    envs.recv();
  }
  return envs.hash();
}

}  // namespace

int main(int count, char** arguments) {
  for (int i = 1; i < count; ++i) {
    std::printf("%s %s\n", arguments[i], to_hex(hash_of(arguments[i])).c_str());
  }
}
