#include "core/io/urdf/urdf_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/math/inertia.h"
#include "core/io/yaml/pose.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

using ::testing::HasSubstr;

std::string inertial(double mass, double i, const std::string& origin = "") {
  const std::string moment = std::to_string(i);
  return "<inertial>" + origin + "<mass value=\"" + std::to_string(mass) + "\"/><inertia ixx=\"" +
         moment + "\" ixy=\"0\" ixz=\"0\" iyy=\"" + moment + "\" iyz=\"0\" izz=\"" + moment +
         "\"/></inertial>";
}

std::string link(const std::string& name, const std::string& content) {
  return "<link name=\"" + name + "\">" + content + "</link>\n";
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& content = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + content + "</joint>\n";
}

std::string axis(const std::string& xyz) { return "<axis xyz=\"" + xyz + "\"/>"; }

RobotModel parse(const std::string& body, UrdfOptions options = {}) {
  Diagnostics diagnostics;
  const auto model =
      parse_urdf("<robot name=\"r\">\n" + body + "</robot>\n", "r.urdf", options, diagnostics);
  EXPECT_TRUE(model.has_value()) << diagnostics.to_string();
  return model.value_or(RobotModel{});
}

void expect_near(const Vec3<double>& a, const Vec3<double>& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

void expect_near(const SymMat3<double>& a, const SymMat3<double>& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.xx, b.xx, tolerance);
  EXPECT_NEAR(a.yy, b.yy, tolerance);
  EXPECT_NEAR(a.zz, b.zz, tolerance);
  EXPECT_NEAR(a.xy, b.xy, tolerance);
  EXPECT_NEAR(a.xz, b.xz, tolerance);
  EXPECT_NEAR(a.yz, b.yz, tolerance);
}

TEST(UrdfMerge, SingleLinkIsTakenBitForBit) {
  const RobotModel model =
      parse(link("base", inertial(1.54, 0.0147, "<origin xyz=\"0.1 0 0.3\"/>")));
  EXPECT_EQ(model.bodies[0].mass.mass, 1.54);
  EXPECT_EQ(model.bodies[0].mass.com.x, 0.1);
  EXPECT_EQ(model.bodies[0].mass.inertia.xx, 0.0147);
}

TEST(UrdfMerge, TwoMassesOnARodMatchTheHandCalculation) {
  // 3 kg at x = 0 and 1 kg at x = 0.8: centre at 0.2; the reduced mass 0.75 kg at 0.8 m adds 0.48.
  const RobotModel model = parse(link("base", inertial(3, 0.1)) + link("tip", inertial(1, 0.02)) +
                                 joint("j", "fixed", "base", "tip", "<origin xyz=\"0.8 0 0\"/>"));
  ASSERT_EQ(model.bodies.size(), 1u);
  EXPECT_NEAR(model.bodies[0].mass.mass, 4.0, 1e-15);
  expect_near(model.bodies[0].mass.com, {0.2, 0, 0});
  expect_near(model.bodies[0].mass.inertia, {0.12, 0.60, 0.60, 0, 0, 0});
  expect_near(model.links[1].pose.position, {0.8, 0, 0});
  expect_near(model.links[1].com, {0.8, 0, 0});
}

TEST(UrdfMerge, RotatedFramesTurnTheInertia) {
  // The tip's x axis points along the base's y: its moments about x and y are exchanged. A quarter
  // turn in the inertial's origin exchanges them back.
  const std::string body = link("base", inertial(1, 0.1));
  const std::string tip_inertia =
      "<mass value=\"1\"/><inertia ixx=\"0.01\" ixy=\"0.002\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" "
      "izz=\"0.025\"/>";
  const std::string turn = "<origin rpy=\"0 0 1.5707963267948966\"/>";
  const RobotModel once = parse(body + link("tip", "<inertial>" + tip_inertia + "</inertial>") +
                                joint("j", "fixed", "base", "tip", turn));
  expect_near(once.bodies[0].mass.inertia, {0.12, 0.11, 0.125, -0.002, 0, 0});
  const RobotModel twice =
      parse(body + link("tip", "<inertial>" + turn + tip_inertia + "</inertial>") +
            joint("j", "fixed", "base", "tip", turn));
  expect_near(twice.bodies[0].mass.inertia, {0.11, 0.12, 0.125, 0.002, 0, 0});
}

TEST(UrdfMerge, ChainOfFixedJointsKeepsShapesAndFrames) {
  const std::string ball =
      "<collision><origin xyz=\"0 0 1\"/><geometry><sphere radius=\"0.5\"/>"
      "</geometry></collision>";
  const RobotModel model = parse(
      link("base", inertial(1, 0.1)) + link("a", "") + link("b", ball) +
      joint("one", "fixed", "base", "a", "<origin xyz=\"1 0 0\" rpy=\"1.5707963267948966 0 0\"/>") +
      joint("two", "fixed", "a", "b", "<origin xyz=\"0 0 1\"/>"));
  ASSERT_EQ(model.bodies[0].collisions.size(), 1u);
  // About x by 90 degrees: z of `a` is -y of the base.
  expect_near(model.bodies[0].collisions[0].pose.position, {1, -2, 0});
  EXPECT_EQ(model.find_link("b"), 2);
  expect_near(model.links[2].pose.position, {1, -1, 0});
}

TEST(UrdfMerge, MasslessLinksWarnOnceEachWithTheirLines) {
  Diagnostics diagnostics;
  const std::string text = "<robot name=\"r\">\n" + link("base", inertial(1, 0.1)) + link("a", "") +
                           link("b", "") + joint("one", "fixed", "base", "a") +
                           joint("two", "fixed", "a", "b") + "</robot>";
  ASSERT_TRUE(parse_urdf(text, "r.urdf", {}, diagnostics));
  EXPECT_EQ(
      diagnostics.to_string(),
      "r.urdf:3:1: warning: the link `a` has no mass; it merges with `base` through the fixed "
      "joint `one`\n"
      "r.urdf:4:1: warning: the link `b` has no mass; it merges with `a` through the fixed joint "
      "`two`\n");
}

TEST(UrdfMerge, ImpossibleInertiaOfALinkInASoundBodyIsAWarning) {
  const std::string flat =
      "<inertial><mass value=\"0.1\"/><inertia ixx=\"0.001\" ixy=\"0\" ixz=\"0\" iyy=\"0.001\" "
      "iyz=\"0\" izz=\"0.01\"/></inertial>";
  Diagnostics diagnostics;
  const std::string text = "<robot name=\"r\">\n" + link("base", inertial(1, 0.1)) +
                           link("a", flat) + joint("one", "fixed", "base", "a") + "</robot>";
  EXPECT_TRUE(parse_urdf(text, "r.urdf", {}, diagnostics));
  EXPECT_THAT(diagnostics.to_string(),
              HasSubstr("r.urdf:3:45: warning: no rigid body has the inertia"));
}

TEST(UrdfJoints, PinAxisBecomesZOfBothFrames) {
  for (const char* xyz : {"0 0 1", "0 0 -1", "1 0 0", "0 -1 0", "1 2 3"}) {
    const RobotModel model =
        parse(link("base", inertial(1, 0.1)) + link("arm", inertial(1, 0.1)) +
              joint("j", "continuous", "base", "arm",
                    std::string("<origin xyz=\"1 0 0\" rpy=\"0.3 0.2 0.1\"/>") + axis(xyz)));
    const Joint& j = model.bodies[1].joint;
    EXPECT_EQ(j.type, JointType::kPin);
    EXPECT_EQ(j.parent, 0);
    // At zero the body's frame is the joint's: X_PF X_BM^-1 is the URDF's origin.
    const Pose at_zero = compose(j.frame_in_parent, inverse(j.frame_in_body));
    expect_near(at_zero.position, {1, 0, 0});
    const Quat<double> origin = from_rpy(0.3, 0.2, 0.1);
    EXPECT_NEAR(std::abs(squared_norm(conjugate(origin) * at_zero.rotation)), 1.0, 1e-12);
    expect_near(rotate(at_zero.rotation, Vec3<double>{1, 2, 3}),
                rotate(origin, Vec3<double>{1, 2, 3}));
    // z of M in the body is the axis.
    double x, y, z;
    ASSERT_EQ(std::sscanf(xyz, "%lf %lf %lf", &x, &y, &z), 3);
    const Vec3<double> a{x, y, z};
    expect_near(rotate(j.frame_in_body.rotation, Vec3<double>{0, 0, 1}), a / norm(a));
  }
}

TEST(UrdfJoints, SliderAxisBecomesX) {
  const RobotModel model = parse(
      link("base", inertial(1, 0.1)) + link("arm", inertial(3, 0.1)) +
      joint("j", "prismatic", "base", "arm",
            axis("0 1 0") + "<limit lower=\"-0.1\" upper=\"0.2\" effort=\"1\" velocity=\"1\"/>" +
                "<dynamics damping=\"0.5\"/>"));
  const Joint& j = model.bodies[1].joint;
  EXPECT_EQ(j.type, JointType::kSlider);
  expect_near(rotate(j.frame_in_body.rotation, Vec3<double>{1, 0, 0}), {0, 1, 0});
  EXPECT_EQ(j.constants[kJointDamping], 0.5);
  EXPECT_TRUE(j.limit.enabled);
  EXPECT_EQ(j.limit.upper, 0.2);
  // Reduced mass of 1 and 3 kg, 100 rad/s, critically damped.
  EXPECT_NEAR(j.constants[kLimitStiffness], 0.75 * 1e4, 1e-9);
  EXPECT_NEAR(j.constants[kLimitDamping], 2 * 0.75 * 100, 1e-9);
}

TEST(UrdfJoints, LimitOnAFixedBaseStopsTheOutboardInertia) {
  const std::string body =
      link("base", inertial(1, 0.1)) + link("arm", inertial(2, 0.1, "<origin xyz=\"0 0 -1\"/>")) +
      joint("j", "revolute", "base", "arm",
            axis("0 1 0") + "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>");
  UrdfOptions fixed;
  fixed.fixed_base = true;
  const RobotModel model = parse(body, fixed);
  EXPECT_TRUE(model.fixed_base);
  EXPECT_EQ(model.bodies[0].joint.type, JointType::kWeld);
  EXPECT_NEAR(model.bodies[1].joint.constants[kLimitStiffness], 2.1 * 1e4, 1e-6);
}

TEST(UrdfJoints, TwoCrossedPinsMakeAUniversalJoint) {
  const RobotModel model = parse(
      link("base", inertial(1, 0.1)) + link("cross", "") + link("arm", inertial(1, 0.1)) +
      joint("one", "continuous", "base", "cross", "<origin xyz=\"0 0 -1\"/>" + axis("0 1 0")) +
      joint("two", "continuous", "cross", "arm", axis("1 0 0")));
  ASSERT_EQ(model.bodies.size(), 2u);
  const Joint& j = model.bodies[1].joint;
  EXPECT_EQ(j.type, JointType::kUniversal);
  EXPECT_EQ(j.name, "two");
  EXPECT_EQ(model.find_link("cross"), -1);
  // First axis: x of F; second: y of M; both here in the base's axes.
  expect_near(rotate(j.frame_in_parent.rotation, Vec3<double>{1, 0, 0}), {0, 1, 0});
  expect_near(rotate(j.frame_in_body.rotation, Vec3<double>{0, 1, 0}), {1, 0, 0});
  expect_near(j.frame_in_parent.position, {0, 0, -1});
}

TEST(UrdfJoints, RotatedFramesInsideAChainCount) {
  // Both axes are `x` in their own frames; the second frame is rotated by 90 degrees about z.
  const RobotModel model =
      parse(link("base", inertial(1, 0.1)) + link("cross", "") + link("arm", inertial(1, 0.1)) +
            joint("one", "continuous", "base", "cross", axis("1 0 0")) +
            joint("two", "continuous", "cross", "arm",
                  "<origin rpy=\"0 0 1.5707963267948966\"/>" + axis("1 0 0")));
  const Joint& j = model.bodies[1].joint;
  ASSERT_EQ(j.type, JointType::kUniversal);
  expect_near(rotate(j.frame_in_body.rotation, Vec3<double>{0, 1, 0}), {1, 0, 0});
  const Pose at_zero = compose(j.frame_in_parent, inverse(j.frame_in_body));
  expect_near(rotate(at_zero.rotation, Vec3<double>{1, 0, 0}), {0, 1, 0});
}

TEST(UrdfJoints, ThreeCrossedPinsMakeABallJoint) {
  const std::string limit =
      "<limit lower=\"-3.1416\" upper=\"3.1416\" effort=\"1\" velocity=\"1\"/>";
  const RobotModel model =
      parse(link("base", inertial(1, 0.1)) + link("a", "") + link("b", "") +
            link("arm", inertial(1, 0.1)) +
            joint("one", "continuous", "base", "a", "<origin xyz=\"1 2 3\"/>" + axis("1 0 0")) +
            joint("two", "revolute", "a", "b", axis("0 1 0") + limit) +
            joint("three", "continuous", "b", "arm", axis("0 0 1")));
  ASSERT_EQ(model.bodies.size(), 2u);
  const Joint& j = model.bodies[1].joint;
  EXPECT_EQ(j.type, JointType::kBall);
  EXPECT_EQ(j.name, "three");
  expect_near(j.frame_in_parent.position, {1, 2, 3});
  EXPECT_EQ(j.frame_in_body.rotation.w, 1.0);
  EXPECT_FALSE(j.limit.enabled);
}

TEST(UrdfJoints, MassBetweenPinsKeepsThemPins) {
  const RobotModel model = parse(
      link("base", inertial(1, 0.1)) + link("cross", inertial(0.1, 0.001)) +
      link("arm", inertial(1, 0.1)) + joint("one", "continuous", "base", "cross", axis("1 0 0")) +
      joint("two", "continuous", "cross", "arm", axis("0 1 0")));
  ASSERT_EQ(model.bodies.size(), 3u);
  EXPECT_EQ(model.bodies[1].joint.type, JointType::kPin);
  EXPECT_EQ(model.bodies[2].joint.parent, 1);
}

std::string errors_of(const std::string& body) {
  Diagnostics diagnostics;
  EXPECT_FALSE(parse_urdf("<robot name=\"r\">\n" + body + "</robot>", "r.urdf", {}, diagnostics));
  return diagnostics.to_string();
}

TEST(UrdfJoints, FloatingJointIsFree) {
  const RobotModel model = parse(link("base", inertial(1, 0.1)) + link("ball", inertial(1, 0.1)) +
                                 joint("j", "floating", "base", "ball", "<origin xyz=\"0 0 2\"/>"));
  EXPECT_EQ(model.bodies[1].joint.type, JointType::kFree);
  expect_near(model.bodies[1].joint.frame_in_parent.position, {0, 0, 2});
}

TEST(UrdfBase, RootCalledWorldFixesTheBase) {
  const RobotModel model =
      parse(link("world", "") + link("base", "") + link("arm", inertial(1, 0.1)) +
            joint("mount", "fixed", "world", "base", "<origin xyz=\"0 0 1\"/>") +
            joint("j", "continuous", "base", "arm", axis("0 1 0")));
  EXPECT_TRUE(model.fixed_base);
  ASSERT_EQ(model.bodies.size(), 2u);
  EXPECT_EQ(model.bodies[0].joint.type, JointType::kWeld);
  expect_near(model.bodies[0].joint.frame_in_parent.position, {0, 0, 1});
  EXPECT_EQ(model.bodies[1].joint.parent, 0);
  EXPECT_EQ(model.find_link("world"), -1);
}

TEST(UrdfBase, FloatingJointOnTheWorldGivesAFreeBase) {
  const RobotModel model = parse(link("world", "") + link("base", inertial(1, 0.1)) +
                                 joint("j", "floating", "world", "base"));
  EXPECT_FALSE(model.fixed_base);
  EXPECT_EQ(model.bodies[0].joint.type, JointType::kFree);
  EXPECT_EQ(model.bodies[0].joint.parent, -1);
}

TEST(UrdfBase, OriginOfAFloatingJointOnTheWorldIsIgnoredWithAWarning) {
  Diagnostics diagnostics;
  const auto model = parse_urdf(
      "<robot name=\"r\">\n" + link("world", "") + link("base", inertial(1, 0.1)) +
          joint("j", "floating", "world", "base", "<origin xyz=\"0 0 1\"/>") + "</robot>\n",
      "r.urdf", {}, diagnostics);
  ASSERT_TRUE(model.has_value());
  EXPECT_TRUE(is_identity(model->bodies[0].joint.frame_in_parent));
  EXPECT_TRUE(is_identity(model->bodies[0].joint.frame_in_body));
  EXPECT_EQ(diagnostics.to_string(),
            "r.urdf:4:1: warning: the <origin> of the floating joint `j` is ignored: the robot's "
            "`pose` places its base\n");
}

TEST(UrdfBase, FixedBaseWeldsWhatFloatsOnTheWorld) {
  const RobotModel model =
      parse(link("world", "") + link("base", "") + link("arm", inertial(1, 0.1)) +
                joint("j", "floating", "world", "base", "<origin xyz=\"0 0 1\"/>") +
                joint("k", "continuous", "base", "arm", axis("0 1 0")),
            {true});
  EXPECT_TRUE(model.fixed_base);
  EXPECT_EQ(model.bodies[0].joint.type, JointType::kWeld);
  expect_near(model.bodies[0].joint.frame_in_parent.position, {0, 0, 1});
}

TEST(UrdfBase, BodyZeroAloneDecidesWhetherTheBaseIsFixed) {
  const RobotModel loose_ball =
      parse(link("world", "") + link("base", inertial(1, 0.1)) + link("ball", inertial(1, 0.1)) +
            joint("j", "fixed", "world", "base") + joint("k", "floating", "base", "ball"));
  EXPECT_TRUE(loose_ball.fixed_base);
  const RobotModel two_on_the_world = parse(
      link("world", "") + link("a", inertial(1, 0.1)) + link("b", inertial(1, 0.1)) +
      joint("j", "fixed", "world", "a") + joint("k", "continuous", "world", "b", axis("0 1 0")));
  EXPECT_TRUE(two_on_the_world.fixed_base);
  EXPECT_EQ(two_on_the_world.bodies[1].joint.parent, -1);
}

TEST(UrdfBase, WhatFloatsOnTheWorldIsItsOnlyChild) {
  const std::string links =
      link("world", "") + link("a", inertial(1, 0.1)) + link("b", inertial(1, 0.1));
  const std::string message = "float, but it is not the only joint on the link `world`";
  EXPECT_THAT(
      errors_of(links + joint("j", "fixed", "world", "a") + joint("k", "floating", "world", "b")),
      HasSubstr("the joint `k` lets `b` " + message));
  EXPECT_THAT(
      errors_of(links + joint("j", "floating", "world", "a") + joint("k", "fixed", "world", "b")),
      HasSubstr("the joint `j` lets `a` " + message));
}

TEST(UrdfBase, PinOnTheWorldHasTheWorldAsParent) {
  const RobotModel model = parse(link("world", "") + link("arm", inertial(1, 0.1)) +
                                 joint("j", "continuous", "world", "arm", axis("0 1 0")));
  EXPECT_TRUE(model.fixed_base);
  EXPECT_EQ(model.bodies[0].joint.type, JointType::kPin);
  EXPECT_EQ(model.bodies[0].joint.parent, -1);
}

TEST(UrdfFiles, NothingReachesStderr) {
  ::testing::internal::CaptureStderr();
  Diagnostics diagnostics;
  parse_urdf("<robot name=\"r\"><link name=\"a\"/><material name=\"m\"/></robot>", "r.urdf", {},
             diagnostics);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_TRUE(diagnostics.has_errors());
}

TEST(UrdfFiles, MissingVisualMeshWarnsAndPrimitivesStay) {
  TempFolder folder;
  const std::string mesh =
      "<visual><geometry><mesh filename=\"package://pack/hull.stl\"/></geometry>"
      "</visual><collision><geometry><sphere radius=\"1\"/></geometry></collision>";
  const std::string text =
      "<robot name=\"r\">" + link("base", inertial(1, 0.1) + mesh) + "</robot>";
  const std::string file = folder.write("pack/urdf/r.urdf", text);
  Diagnostics before;
  const auto model = read_urdf(file, {}, before);
  ASSERT_TRUE(model.has_value());
  EXPECT_THAT(before.to_string(), HasSubstr(":1:177: warning: the mesh `package://pack/hull.stl`"));
  EXPECT_TRUE(model->bodies[0].visuals.empty());
  EXPECT_EQ(model->bodies[0].collisions.size(), 1u);
  folder.write("pack/hull.stl", "solid");
  Diagnostics after;
  const auto with_mesh = read_urdf(file, {}, after);
  ASSERT_TRUE(with_mesh.has_value());
  EXPECT_EQ(after.to_string(), "");
  EXPECT_EQ(with_mesh->bodies[0].visuals.at(0).type, ShapeType::kMesh);
}

TEST(UrdfFiles, FilesOfOthersLoadWithAWarningEach) {
  const std::string folder = std::string(SKYBODY_SOURCE_DIR) + "/../shared/data/urdf/";
  if (!std::filesystem::exists(folder + "cf2x.urdf")) GTEST_SKIP() << folder << " is not here";
  for (const char* name : {"cf2x", "cf2p", "racer"}) {
    Diagnostics diagnostics;
    const auto model = read_urdf(folder + name + ".urdf", {}, diagnostics);
    ASSERT_TRUE(model.has_value()) << diagnostics.to_string();
    EXPECT_EQ(model->bodies.size(), 1u);
    EXPECT_EQ(model->links.size(), 6u);
    EXPECT_EQ(diagnostics.all().size(), 7u)
        << diagnostics.to_string();  // properties, mesh, 5 links
    for (const Diagnostic& d : diagnostics.all()) {
      EXPECT_GT(d.mark.line, 0);
      EXPECT_GT(d.mark.column, 0);
    }
    EXPECT_TRUE(is_physical_inertia(model->bodies[0].mass.inertia));
  }
}

TEST(UrdfFiles, PayloadHasTwoBallJoints) {
  Diagnostics diagnostics;
  const auto model = read_urdf(
      std::string(SKYBODY_SOURCE_DIR) + "/scenarios/models/qdrone2_payload/qdrone2_payload.urdf",
      {}, diagnostics);
  ASSERT_TRUE(model.has_value()) << diagnostics.to_string();
  EXPECT_EQ(diagnostics.to_string(), "");
  ASSERT_EQ(model->bodies.size(), 3u);
  EXPECT_EQ(model->bodies[1].joint.type, JointType::kBall);
  EXPECT_EQ(model->bodies[2].joint.type, JointType::kBall);
  EXPECT_NEAR(model->total_mass(), 1.757, 1e-12);
}

TEST(UrdfFiles, RpyOfHalfATurnIsExactEnough) {
  const RobotModel model =
      parse(link("base", inertial(1, 0.1)) + link("a", inertial(1, 0.1)) +
            joint("j", "fixed", "base", "a", "<origin rpy=\"0 0 3.141592653589793\"/>"));
  expect_near(rotate(model.links[1].pose.rotation, Vec3<double>{1, 0, 0}), {-1, 0, 0}, 1e-15);
}

}  // namespace
}  // namespace skybody
