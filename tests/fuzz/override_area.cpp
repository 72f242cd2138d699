// Values of `--set`, one per line. The first line names a shipped scenario.
#include <sstream>

#include "tests/fuzz/areas.h"
#include "tests/fuzz/files.h"
#include "tests/fuzz/flight_check.h"
#include "tests/fuzz/yaml_words.h"

namespace skybody::fuzz {
namespace {

const char* const kScenarios[] = {"hover", "payload", "collision", "boom"};

const char* const kSeeds[] = {
    "hover\nstepping.dt=0.002\nrobots.quad.pose.position=[0, 0, 2]\n",
    "hover\nrobots[0].controllers=[{plugin: ctbr, parameters: {kp: [20, 20, 8]}}]\n",
    "hover\ntask.parameters.target=[0, 0, 1, 0]\nrandomization[0].parameters.yaw_max=0.5\n",
    "payload\nstepping={dt: 0.001, action_repeat: 2, integrator: rk4}\ngravity=[0, 0, -3.7]\n",
    "payload\nrandomization.inertia.parameters.mass=[0.5, 2]\nsensors[0].parameters.period=2\n",
    "collision\ncontact.friction=0.1\nrobots.left.pose.rpy=[0, 0, 3]\nrobots[1].rotor_speed=100\n",
    "boom\nrobots.quad.joints.boom_1.stiffness=1e3\nstepping.solver={max_steps: 1000}\n",
    "hover\nobstacles=[{name: wall, box: [0.1, 0.1, 0.1]}]\nstepping.dynamics=simbody\n",
};

class OverrideArea : public Area {
 public:
  OverrideArea() {
    material_.seeds.assign(std::begin(kSeeds), std::end(kSeeds));
    material_.words = yaml_words();
    for (const char* path : {"robots[0]", "robots.quad.", "[-1]", "[99999999999]", "=", "..",
                             "controllers[0].parameters", "stepping.", "robots[0][0]"}) {
      material_.words.emplace_back(path);
    }
  }

  void begin(const std::filesystem::path&) override {}

  Answer run(const std::string& input, bool thorough) override {
    std::istringstream lines(input);
    std::string line;
    std::getline(lines, line);
    LoadOptions options;
    options.scenario = known(line);
    while (std::getline(lines, line)) options.overrides.push_back(line);
    return check_flight(options, thorough);
  }

  std::size_t smallest_leak() const override { return kSmallLeak; }

 private:
  static std::string known(const std::string& name) {
    for (const char* scenario : kScenarios) {
      if (name == scenario) return name;
    }
    return kScenarios[0];
  }
};

}  // namespace

std::unique_ptr<Area> make_override_area(const AreaOptions&) {
  return std::make_unique<OverrideArea>();
}

}  // namespace skybody::fuzz
