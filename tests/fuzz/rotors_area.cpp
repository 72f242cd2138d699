#include "tests/fuzz/areas.h"
#include "tests/fuzz/model_area.h"
#include "tests/fuzz/yaml_words.h"

namespace skybody::fuzz {
namespace {

constexpr const char* kScenario = R"(robots:
  - name: quad
    model: models/qdrone2/qdrone2.urdf
    rotors: input_rotors.yaml
    pose: {position: [0, 0, 1]}
    rotor_speed: hover
    controllers: [{plugin: ctbr}]
task: {plugin: hover}
)";

/// Every key, in a file that includes another.
constexpr const char* kOwn = R"(include: models/racer/rotors.yaml
defaults: {inertia: 1e-6, direction: ccw, thrust_constant: 2e-6, moment_constant: 3e-8, max_speed: 2000}
rotors:
  - {name: a, link: base_link, position: [0.1, 0.1, 0], axis: [0, 0, 1], tau_up: 0.01, tau_down: 0.02}
  - {name: b, position: [-0.1, 0.1, 0], direction: cw, axis: [0, 0.1, 1]}
  - {name: c, position: [0.1, -0.1, 0], direction: cw, rolling_moment_constant: 1e-9}
  - {name: d, position: [-0.1, -0.1, 0.05], drag_constant: 2e-5}
)";

class RotorsArea : public ModelArea {
 public:
  RotorsArea() : ModelArea("input_rotors.yaml", kScenario) {
    material_.seeds = {shipped("models/qdrone2/rotors.yaml"), kOwn};
    material_.words = yaml_words();
    for (const char* link : {"rotor_front_left", "rotor_back_right", "ccw", "cw", "front_left"}) {
      material_.words.emplace_back(link);
    }
  }
};

}  // namespace

std::unique_ptr<Area> make_rotors_area(const AreaOptions&) {
  return std::make_unique<RotorsArea>();
}

}  // namespace skybody::fuzz
