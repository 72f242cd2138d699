#include "core/io/yaml/scenario_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/urdf/urdf_reader.h"
#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/rotors_reader.h"
#include "core/io/yaml/scenario_fields.h"
#include "tests/unit/io/fake_catalog.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

using ::testing::HasSubstr;

const char* const kModel = R"(<robot name="r">
  <link name="base"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="mount"/>
  <joint name="tilt" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="0" velocity="0"/><dynamics damping="0.25"/></joint>
  <joint name="fix" type="fixed"><origin xyz="0 0 1" rpy="1.5707963267948966 0 0"/><parent link="arm"/><child link="mount"/></joint>
</robot>)";

const char* const kRotors = R"(source: a test
defaults: {direction: ccw, thrust_constant: 1.0e-6, moment_constant: 1.0e-8, max_speed: 1000}
rotors:
  - {name: base, position: [1, 0, 0]}
  - {name: arm, link: mount, position: [0, 0, 0.5], axis: [0, 0, 2], direction: cw, tau_up: 0.01}
)";

class ScenarioTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.write("models/r.urdf", kModel);
    folder_.write("models/rotors.yaml", kRotors);
  }

  std::optional<Scenario> read(const std::string& text,
                               const std::vector<std::string>& overrides = {}) {
    diagnostics_ = Diagnostics();
    return read_scenario(folder_.write("s.yaml", text), overrides, catalog_, diagnostics_);
  }

  Scenario good(const std::string& text, const std::vector<std::string>& overrides = {}) {
    const auto scenario = read(text, overrides);
    EXPECT_TRUE(scenario.has_value()) << diagnostics_.to_string();
    return scenario.value_or(Scenario{});
  }

  std::string messages(const std::string& text) {
    EXPECT_FALSE(read(text).has_value());
    return diagnostics_.to_string();
  }

  TempFolder folder_;
  FakeCatalog catalog_;
  Diagnostics diagnostics_;
};

const char* const kSmall =
    "robots: [{name: quad, model: models/r.urdf}]\n"
    "task: {plugin: hover}\n";

TEST_F(ScenarioTest, DefaultsAreThoseOfTheModel) {
  const Scenario s = good(kSmall);
  const Stepping stepping;
  const ContactSettings contact;
  EXPECT_EQ(s.name, "s");
  EXPECT_EQ(s.stepping.dt, stepping.dt);
  EXPECT_EQ(s.stepping.action_repeat, stepping.action_repeat);
  EXPECT_EQ(s.stepping.horizon, stepping.horizon);
  EXPECT_EQ(s.gravity().z, -9.81);
  EXPECT_EQ(s.contact.penetration, contact.penetration);
  EXPECT_EQ(s.constants[kFriction], 0.6);
  EXPECT_EQ(s.constants[kDissipation], 3.0);
  EXPECT_EQ(s.robots.at(0).rotor_speed, 0.0);
  EXPECT_EQ(s.task.instance, "hover");
}

TEST_F(ScenarioTest, EveryKeyArrives) {
  const Scenario s = good(R"(
name: all
stepping: {dt: 0.002, action_repeat: 5, horizon: 100, dynamics: simbody, integrator: rk4}
gravity: [0, 0, -1.62]
contact: {ground: false, penetration: 0.01, dissipation: 2, friction: 0.1}
robots:
  - name: quad
    model: models/r.urdf
    pose: {position: [1, 2, 3], rpy: [0, 0, 1.5707963267948966]}
    rotor_speed: hover
    disturbance: {force: [1, 0, 0], moment: [0, 2, 0]}
    joints: {tilt: {stiffness: 3, rest: 0.1, limit_damping: 7}}
    controllers:
      - {plugin: rotor_speed, name: motors, parameters: {max_speed: 900}}
      - plugin: ctbr
        parameters: {apply: body, gain: 2, list: [1, 2], order: 3, filter: false}
obstacles:
  - {name: wall, box: [1, 2, 3], position: [0, 0, 1]}
  - {name: post, cylinder: [0.1, 2]}
  - {name: ball, sphere: 0.5}
sensors: [{plugin: imu, name: imu2, parameters: {robot: quad}}]
randomization: [{plugin: start}]
task: {plugin: hover, name: fly, parameters: {robot: quad}}
)");
  EXPECT_EQ(s.stepping.dynamics, DynamicsChoice::kSimbody);
  EXPECT_EQ(s.stepping.dynamics_mark.line, 3);
  EXPECT_EQ(s.stepping.integrator, IntegratorChoice::kRk4);
  EXPECT_FALSE(s.contact.ground);
  const RobotUse& robot = s.robots.at(0);
  EXPECT_LT(robot.rotor_speed, 0.0);
  EXPECT_EQ(robot.pose.position.y, 2.0);
  EXPECT_NEAR(robot.pose.rotation.z, 0.70710678118654752, 1e-15);
  EXPECT_EQ(robot.constants[kDisturbanceMoment + 1], 2.0);
  const Joint& joint = robot.model.bodies.at(1).joint;
  EXPECT_EQ(joint.constants[kJointDamping], 0.25);  // the URDF's value remains
  EXPECT_EQ(joint.constants[kJointStiffness], 3.0);
  EXPECT_EQ(joint.constants[kLimitDamping], 7.0);
  EXPECT_GT(joint.constants[kLimitStiffness], 0.0);
  ASSERT_EQ(robot.controllers.size(), 2u);
  EXPECT_EQ(robot.controllers[0].instance, "motors");
  EXPECT_EQ(robot.controllers[1].parameters.at(1).numbers, (std::vector<double>{2, 2, 2}));
  EXPECT_EQ(robot.controllers[1].parameters.at(0).texts.at(0), "body");
  ASSERT_EQ(s.obstacles.size(), 3u);
  EXPECT_EQ(s.obstacles[1].shape.length, 2.0);
  EXPECT_EQ(s.sensors.at(0).parameters.at(0).texts.at(0), "quad");
  EXPECT_EQ(s.task.instance, "fly");
}

TEST_F(ScenarioTest, RotorsBesideTheUrdfAreFoundAndPlacedInBodyFrames) {
  const Scenario s = good(kSmall);
  const std::vector<Rotor>& rotors = s.robots[0].model.rotors;
  ASSERT_EQ(rotors.size(), 2u);
  EXPECT_EQ(rotors[0].body, 0);
  EXPECT_EQ(rotors[0].direction, 1);
  EXPECT_EQ(rotors[1].body, 1);
  EXPECT_EQ(rotors[1].direction, -1);
  // mount: 1 m above the arm's frame, rotated about x by 90 degrees: its z is the arm's -y.
  EXPECT_NEAR(rotors[1].position().y, -0.5, 1e-15);
  EXPECT_NEAR(rotors[1].position().z, 1.0, 1e-15);
  EXPECT_NEAR(rotors[1].axis.y, -1.0, 1e-15);
  EXPECT_EQ(rotors[1].constants[kTauUp], 0.01);
}

TEST_F(ScenarioTest, RotorsNoneMeansNone) {
  EXPECT_TRUE(
      good("robots: [{name: q, model: models/r.urdf, rotors: none}]\ntask: {plugin: hover}\n")
          .robots[0]
          .model.rotors.empty());
}

TEST_F(ScenarioTest, FixedBaseWeldsIt) {
  const Scenario s = good(kSmall, {"robots.quad.fixed_base=true"});
  EXPECT_TRUE(s.robots[0].model.fixed_base);
  EXPECT_EQ(s.robots[0].model.bodies[0].joint.type, JointType::kWeld);
}

TEST_F(ScenarioTest, PathsAreRelativeToTheFileThatNamesThem) {
  folder_.write("lib/part.yaml", "robots: [{name: quad, model: ../models/r.urdf}]\n");
  const Scenario s = good("include: lib/part.yaml\ntask: {plugin: hover}\n");
  EXPECT_EQ(s.robots[0].model.urdf_file, folder_.path("models/r.urdf"));
}

TEST_F(ScenarioTest, ModelsOfSeveralRobotsWarnOnce) {
  good(
      "robots:\n  - {name: a, model: models/r.urdf}\n  - {name: b, model: models/r.urdf}\n"
      "task: {plugin: hover}\n");
  EXPECT_EQ(diagnostics_.all().size(), 1u) << diagnostics_.to_string();
}

TEST_F(ScenarioTest, HashFollowsTextFilesAndDefaults) {
  const std::uint64_t first = good(kSmall).hash;
  EXPECT_EQ(good(kSmall).hash, first);
  EXPECT_EQ(good(std::string("# a comment\n") + kSmall).hash, first);
  EXPECT_NE(good(kSmall, {"stepping.dt=0.002"}).hash, first);
  folder_.write("models/rotors.yaml", std::string(kRotors) + "\n# comment\n");
  EXPECT_EQ(good(kSmall).hash, first);
  std::string other = kRotors;
  other.replace(other.find("1000"), 4, "1001");
  folder_.write("models/rotors.yaml", other);
  EXPECT_NE(good(kSmall).hash, first);
  folder_.write("models/rotors.yaml", kRotors);
  folder_.write("models/r.urdf", std::string(kModel) + "<!-- x -->");
  EXPECT_NE(good(kSmall).hash, first);
}

TEST_F(ScenarioTest, TextReadsBackToTheSameScenario) {
  const Scenario s = good(kSmall, {"stepping={dt: 0.002}"});
  EXPECT_EQ(good(s.text).hash, s.hash);
}

TEST_F(ScenarioTest, PluginThatCannotBeLoadedIsReportedWhereItIsUsed) {
  EXPECT_THAT(messages("robots:\n  - name: q\n    model: models/r.urdf\n"
                       "    controllers: [{plugin: broken}]\ntask: {plugin: hover}\n"),
              HasSubstr("s.yaml:4:28: error: the controller `broken` cannot be used: "
                        "it is truncated"));
}

TEST_F(ScenarioTest, NamesThatNoPluginOfTheKindHasAreExplained) {
  const auto said_of = [&](const std::string& task) {
    return messages("robots: [{name: q, model: models/r.urdf}]\ntask: {plugin: " + task + "}\n");
  };
  const std::string unknown = "s.yaml:2:16: error: unknown task ";
  EXPECT_THAT(said_of("ctbr"), HasSubstr(unknown + "`ctbr`; `ctbr` is a controller\n"));
  EXPECT_THAT(said_of("payload"), HasSubstr(unknown + "`payload`: it is not built here; "
                                                      "`./dev build` makes all plugins"));
  // The name is in a closed library: a close match exists, but no plugin of the kind can be listed.
  EXPECT_THAT(said_of("my_own_lw"), HasSubstr("did you mean `my_own_law`?"));
  EXPECT_THAT(said_of("zzzzzzzz"), HasSubstr("; found: hover; more folders"));
}

TEST_F(ScenarioTest, RequiredParameterIsMissing) {
  EXPECT_THAT(messages(std::string(kSmall) + "sensors: [{plugin: imu}]\n"),
              HasSubstr("s.yaml:3:20: error: the parameter `robot` is missing"));
}

TEST_F(ScenarioTest, ErrorsOfAllPartsComeTogether) {
  const std::string all = messages(
      "robots: [{name: quad, model: models/nowhere.urdf, rotor_speed: fast}]\n"
      "sensors: 3\nobstacles: [{name: x}]\ntask: {plugin: hver}\nwnd: 1\n");
  for (const char* part : {"does not exist", "`rotor_speed` is the text `fast`", "sensors are",
                           "has no shape", "did you mean `hover`", "unknown key `wnd`"}) {
    EXPECT_THAT(all, HasSubstr(part));
  }
}

TEST_F(ScenarioTest, ThrowCarriesEveryError) {
  read("robots: 1\ntask: 2\n");
  try {
    diagnostics_.throw_if_errors();
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_EQ(error.diagnostics().size(), diagnostics_.all().size());
    EXPECT_THAT(error.what(), HasSubstr("`robots` is the number 1"));
    EXPECT_THAT(error.what(), HasSubstr("is the number 2"));
  }
}

TEST(ShippedScenarios, ModelsAndRotorsAreSound) {
  const std::filesystem::path models = std::string(SKYBODY_SOURCE_DIR) + "/scenarios/models";
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(models)) {
    const std::string name = entry.path().filename().string();
    const std::string urdf = (entry.path() / (name + ".urdf")).string();
    if (!std::filesystem::exists(urdf)) continue;
    Diagnostics diagnostics;
    auto model = read_urdf(urdf, {}, diagnostics);
    ASSERT_TRUE(model.has_value()) << diagnostics.to_string();
    const std::string rotors = (entry.path() / "rotors.yaml").string();
    if (!std::filesystem::exists(rotors)) continue;  // loads and standing objects have no rotors
    std::string text;
    InputBudget budget;
    read_rotors(rotors, {}, *model, text, diagnostics, budget);
    EXPECT_EQ(diagnostics.to_string(), "");
    EXPECT_GE(model->rotors.size(), 3u) << name;
    // It can hover, and in hover its drag torques cancel; with three rotors a servo balances the
    // rest.
    double thrust = 0.0, torque = 0.0;
    for (const Rotor& rotor : model->rotors) {
      thrust += rotor.constants[kThrustConstant] * rotor.constants[kMaxSpeed] *
                rotor.constants[kMaxSpeed];
      torque += rotor.direction * rotor.constants[kMomentConstant];
    }
    EXPECT_GT(thrust, 1.2 * 9.81 * model->total_mass()) << name;
    if (model->rotors.size() > 3) {
      EXPECT_EQ(torque, 0.0) << name;
    }
    ++count;
  }
  EXPECT_GE(count, 5);
}

}  // namespace
}  // namespace skybody
