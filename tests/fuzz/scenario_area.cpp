// YAML scenarios. A line `#file NAME` begins another file, which the first may include.
#include "core/io/files/shipped_files.h"
#include "tests/fuzz/areas.h"
#include "tests/fuzz/files.h"
#include "tests/fuzz/flight_check.h"
#include "tests/fuzz/yaml_words.h"

namespace skybody::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = "#file ";
/// Files of one input; more are ignored.
constexpr std::size_t kMostFiles = 32;

const char* const kShipped[] = {
    "hover",       "payload",       "formation_2", "collision",           "boom", "hard_landing",
    "hover_learn", "hover_firefly", "four_bar",    "cooperative_payload", "arm"};

/// Features that shipped scenarios lack: obstacles, anchors, several includes.
// Boxes are small: Simbody takes a third of a second to prepare one of a metre.
const char* const kOwn[] = {
    R"(include: hover.yaml
sensors: [{plugin: imu, name: eye}]
observe:
  - eye.angular_rate
  - {channel: eye.specific_force, name: force, low: -50, high: 50, privileged: true}
)",
    R"(include: [a.yaml, b.yaml]
name: parts
task: {plugin: hover}
#file a.yaml
stepping: &stepping {dt: 0.001, action_repeat: 2, horizon: 100}
robots:
  - &robot {name: one, model: models/hummingbird/hummingbird.urdf, controllers: [{plugin: srt}]}
#file b.yaml
include: c.yaml
gravity: [0, 0, -9.81]
robots:
  - name: one
    model: models/crazyflie/crazyflie.urdf
    pose: {position: [0, 0, 1], rpy: [0, 0, 0.5]}
    controllers: [{plugin: ctbr, parameters: {kp: [20, 20, 8]}}]
#file c.yaml
contact: {ground: true, friction: 0.5}
)",
    R"(stepping: {dt: 0.002, integrator: rk4, dynamics: simbody}
gravity: [0, 0, -9.81]
contact: {penetration: 0.001, dissipation: 3, friction: 0.6}
robots:
  - name: quad
    model: models/hummingbird/hummingbird.urdf
    rotors: models/hummingbird/rotors.yaml
    pose: {position: [0, 0, 1], rpy: [0.1, 0.2, 0.3]}
    rotor_speed: 100
    disturbance: {force: [0.1, 0, 0], moment: [0, 0, 0.01]}
    controllers: [{plugin: position}, {plugin: attitude}, {plugin: ctbr}]
obstacles:
  - {name: wall, box: [0.1, 0.2, 0.1], position: [3, 0, 1], rpy: [0, 0, 0.1]}
  - {name: pole, cylinder: [0.1, 0.2], position: [0, 3, 1]}
  - {name: ball, sphere: 0.5, position: [0, -3, 1]}
sensors:
  - {plugin: imu, name: imu_1, parameters: {link: base_link, period: 2, latency: 3}}
randomization:
  - {plugin: draw, parameters: {what: [robots.quad.links.base_link.mass], range: [0.9, 1.1], form: scale}}
  - {plugin: vehicle_constants, name: inertia, parameters: {inertia: [0.9, 1.1], every: 2}}
task: {plugin: hover, parameters: {target: [0, 0, 1, 0]}}
)"};

/// Writes the files of an input.
class Bundle {
 public:
  Bundle(const std::string& input, fs::path folder) : folder_(std::move(folder)) {
    std::size_t at = 0;
    std::string name = "input.yaml";
    for (std::size_t mark; (mark = find_mark(input, at)) != std::string::npos;) {
      write(name, input.substr(at, mark - at));
      const std::size_t end = std::min(input.find('\n', mark), input.size());
      name = input.substr(mark + 6, end - mark - 6);
      at = std::min(end + 1, input.size());
    }
    write(name, input.substr(at));
  }
  ~Bundle() {
    std::error_code ignored;
    for (const fs::path& file : files_) fs::remove(file, ignored);
  }
  Bundle(const Bundle&) = delete;
  Bundle& operator=(const Bundle&) = delete;

 private:
  static std::size_t find_mark(const std::string& input, std::size_t from) {
    if (from == 0 && input.rfind(kMark, 0) == 0) return 0;
    const std::size_t found = input.find(std::string("\n") + kMark, from > 0 ? from - 1 : 0);
    return found == std::string::npos ? found : found + 1;
  }

  /// Writes only inside the folder, and never over a shipped file.
  void write(const std::string& name, const std::string& text) {
    const bool plain =
        !name.empty() && name.size() < 32 && name[0] != '.' &&
        name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") == std::string::npos;
    if (!plain || files_.size() == kMostFiles) return;
    const fs::path file = folder_ / name;
    if (fs::exists(file)) return;
    write_bytes(file, text);
    files_.push_back(file);
  }

  fs::path folder_;
  std::vector<fs::path> files_;
};

class ScenarioArea : public Area {
 public:
  ScenarioArea() {
    for (const char* name : kShipped)
      material_.seeds.push_back(read_bytes(*find_shipped_scenario(name)));
    for (const char* text : kOwn) material_.seeds.emplace_back(text);
    material_.words = yaml_words();
  }

  void begin(const fs::path& folder) override {
    folder_ = folder;
    copy_scenarios(folder);
  }

  Answer run(const std::string& input, bool thorough) override {
    const Bundle bundle(input, folder_);
    LoadOptions options;
    options.scenario = (folder_ / "input.yaml").string();
    return check_flight(options, thorough);
  }

  std::size_t smallest_leak() const override { return kSmallLeak; }

 private:
  fs::path folder_;
};

}  // namespace

std::unique_ptr<Area> make_scenario_area(const AreaOptions&) {
  return std::make_unique<ScenarioArea>();
}

}  // namespace skybody::fuzz
