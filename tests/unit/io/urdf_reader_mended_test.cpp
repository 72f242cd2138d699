// Gaps in a URDF that its reader fills with a warning: inertias, massless links, joints that cannot
// move.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/math/inertia.h"
#include "core/io/urdf/urdf_reader.h"
#include "core/io/yaml/fold_warnings.h"

namespace skybody {
namespace {

using ::testing::HasSubstr;

std::string inertial(double mass, const std::string& moments) {
  return "<inertial><mass value=\"" + std::to_string(mass) + "\"/><inertia " + moments +
         "/></inertial>";
}

const std::string kMoments = R"(ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1")";

std::string link(const std::string& name, const std::string& content) {
  return "<link name=\"" + name + "\">" + content + "</link>\n";
}
std::string heavy(const std::string& name) { return link(name, inertial(1.0, kMoments)); }

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& content = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + content + "</joint>\n";
}

std::string axis(const std::string& xyz) { return "<axis xyz=\"" + xyz + "\"/>"; }

const std::string kLimit = R"(<limit lower="-1" upper="1"/>)";

/// A model, or none, and all messages about it.
struct Read {
  std::optional<RobotModel> model;
  std::string messages;
};

Read read(const std::string& body, const UrdfOptions& options = {}) {
  Diagnostics diagnostics;
  Read result;
  result.model =
      parse_urdf("<robot name=\"r\">\n" + body + "</robot>", "r.urdf", options, diagnostics);
  result.messages = diagnostics.to_string();
  return result;
}

TEST(UrdfInertia, ErrorNamesTheBoundAndTheRemedy) {
  const Read flat = read(
      link("base", inertial(1, R"(ixx="0.04" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.09")")));
  EXPECT_FALSE(flat.model);
  EXPECT_THAT(flat.messages,
              HasSubstr("izz must not exceed ixx + iyy, 0.08; `inertia: repair` of the robot "
                        "mends it"));
  const Read turned = read(
      link("base", inertial(1, R"(ixx="0.04" ixy="0.01" ixz="0" iyy="0.04" iyz="0" izz="0.09")")));
  EXPECT_THAT(turned.messages, HasSubstr("the largest must not exceed the sum of the other two, "
                                         "0.08;"));
}

TEST(UrdfInertia, RepairLowersTheLargestMomentToTheBoundAndSaysSo) {
  UrdfOptions repair;
  repair.repair_inertia = true;
  const Read read_anew =
      read(link("base", inertial(1, R"(ixx="0.04" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.09")")),
           repair);
  ASSERT_TRUE(read_anew.model) << read_anew.messages;
  const SymMat3<double>& inertia = read_anew.model->bodies[0].mass.inertia;
  EXPECT_NEAR(inertia.xx, 0.04, 1e-15);
  EXPECT_NEAR(inertia.zz, 0.08, 1e-15);
  EXPECT_EQ(read_anew.messages,
            "r.urdf:2:53: warning: `inertia: repair` gives the link `base` the principal moments "
            "[0.04, 0.04, 0.08] kg m^2; written are [0.04, 0.04, 0.09]\n");
}

TEST(UrdfInertia, RepairKeepsTheAxesAndRaisesWhatIsNotPositive) {
  const SymMat3<double> written{0.04, 0.04, 0.2, 0.03, 0.0, 0.0};  // moments 0.01, 0.07, 0.2
  const SymMat3<double> mended = repaired_inertia(written, 1.0);
  EXPECT_TRUE(is_physical_inertia(mended));
  EXPECT_NEAR(mended.xx, 0.04, 1e-12);  // the axis of the largest moment is z
  EXPECT_NEAR(mended.xy, 0.03, 1e-12);
  EXPECT_NEAR(mended.zz, 0.08, 1e-12);
  // A body without inertia gets a radius of gyration of 1 mm.
  const Vec3<double> none = eigenvalues(repaired_inertia({0, 0, 0, 0, 0, 0}, 2.0));
  EXPECT_NEAR(none.x, 2e-6, 1e-15);
  EXPECT_NEAR(none.z, 2e-6, 1e-15);
}

TEST(UrdfInertia, RepairLeavesSoundBodiesBitForBit) {
  UrdfOptions repair;
  repair.repair_inertia = true;
  const std::string sound =
      link("base", inertial(1, R"(ixx="0.031" ixy="1e-4" ixz="0" iyy="0.03" iyz="0" izz="0.05")"));
  const SymMat3<double> a = read(sound).model->bodies[0].mass.inertia;
  const Read again = read(sound, repair);
  const SymMat3<double> b = again.model->bodies[0].mass.inertia;
  EXPECT_EQ(a.xx, b.xx);
  EXPECT_EQ(a.xy, b.xy);
  EXPECT_EQ(again.messages, "");
}

TEST(UrdfInertia, MirroredProductsMayStandBesideTheirOwn) {
  const std::string both =
      R"(ixx="0.1" ixy="0.01" iyx="0.01" ixz="0" izx="0" iyy="0.1" iyz="0" izy="0" izz="0.1")";
  const Read same = read(link("base", inertial(1, both)));
  EXPECT_TRUE(same.model);
  EXPECT_EQ(same.messages, "");
  EXPECT_THAT(read(link("base", inertial(1, R"(ixx="1" iyx="0" ixz="0" iyy="1" iyz="0" izz="1")")))
                  .messages,
              HasSubstr("<inertia> of the link `base` has `iyx` and no `ixy`; URDF has the "
                        "elements ixy, ixz and iyz: write it as `ixy`"));
  EXPECT_THAT(
      read(link("base",
                inertial(1, R"(ixx="1" ixy="0.1" iyx="0.2" ixz="0" iyy="1" iyz="0" izz="1")")))
          .messages,
      HasSubstr("the inertia of the link `base` is not symmetric: ixy is [0.1] and iyx is [0.2]; "
                "remove `iyx`"));
}

TEST(UrdfShapes, OriginInGeometryIsToldWhereItBelongs) {
  const std::string shape =
      "<collision><geometry><origin xyz=\"0 0 1\"/><sphere radius=\"1\"/></geometry></collision>";
  EXPECT_THAT(read(link("base", inertial(1, kMoments) + shape)).messages,
              HasSubstr("<origin> stands in <geometry> of the link `base`; move it out of "
                        "<geometry>, into <collision>"));
}

TEST(UrdfLimits, EffortAndVelocityMayBeLeftOut) {
  const Read read_model =
      read(heavy("base") + heavy("arm") + joint("j", "revolute", "base", "arm", kLimit));
  ASSERT_TRUE(read_model.model) << read_model.messages;
  EXPECT_EQ(read_model.model->bodies[1].joint.limit.upper, 1.0);
  EXPECT_EQ(read_model.messages, "");
}

TEST(UrdfLimits, LimitsWithoutTravelAdviseFixed) {
  const Read stuck = read(heavy("base") + heavy("arm") +
                          joint("j", "revolute", "base", "arm", R"(<limit lower="0" upper="0"/>)"));
  ASSERT_TRUE(stuck.model) << stuck.messages;
  EXPECT_EQ(stuck.model->bodies.size(), 1u);
  EXPECT_THAT(stuck.messages, HasSubstr("warning: the joint `j` is read as fixed: its limits are 0 "
                                        "to 0; make it `fixed`"));
  EXPECT_THAT(read(heavy("base") + heavy("arm") +
                   joint("j", "revolute", "base", "arm", R"(<limit lower="1" upper="1"/>)"))
                  .messages,
              HasSubstr("the limits of the joint `j` are 1 to 1; lower must be less than upper: a "
                        "joint that cannot move is `fixed`, one without limits is `continuous`"));
}

TEST(UrdfMassless, LimitsKeepTwoPinsWithALightLinkBetween) {
  const Read limited = read(heavy("base") + link("cross", "") + heavy("arm") +
                            joint("one", "revolute", "base", "cross", axis("1 0 0") + kLimit) +
                            joint("two", "continuous", "cross", "arm", axis("0 1 0")));
  ASSERT_TRUE(limited.model) << limited.messages;
  ASSERT_EQ(limited.model->bodies.size(), 3u);
  const Body& cross = limited.model->bodies[1];
  EXPECT_EQ(cross.name, "cross");
  EXPECT_EQ(cross.joint.type, JointType::kPin);
  EXPECT_TRUE(cross.joint.limit.enabled);
  EXPECT_DOUBLE_EQ(cross.mass.mass, 1e-6);
  EXPECT_TRUE(is_physical_inertia(cross.mass.inertia));
  EXPECT_EQ(limited.model->bodies[2].joint.parent, 1);
  EXPECT_EQ(limited.messages,
            "r.urdf:3:1: warning: the link `cross` has no <inertial> and moves on the joint `one`; "
            "it gets 1e-06 kg, a millionth of what hangs on it (no part of a universal or ball "
            "joint: `one` has limits)\n");
}

TEST(UrdfMassless, JointsOfTheirOwnStayOutOfUniversalJoints) {
  const std::string body = heavy("base") + link("cross", "") + heavy("arm") +
                           joint("one", "continuous", "base", "cross", axis("1 0 0")) +
                           joint("two", "continuous", "cross", "arm", axis("0 1 0"));
  EXPECT_EQ(read(body).model->bodies.size(), 2u);
  UrdfOptions options;
  options.own_joints = {"one"};
  EXPECT_EQ(read(body, options).model->bodies.size(), 3u);
}

TEST(UrdfMassless, InnerLinksKeepTheirShapes) {
  const std::string ball = "<visual><geometry><sphere radius=\"0.1\"/></geometry></visual>";
  const Read shaped = read(heavy("base") + link("cross", ball) + heavy("arm") +
                           joint("one", "continuous", "base", "cross", axis("1 0 0")) +
                           joint("two", "continuous", "cross", "arm", axis("0 1 0")));
  ASSERT_TRUE(shaped.model) << shaped.messages;
  ASSERT_EQ(shaped.model->bodies.size(), 3u);
  EXPECT_EQ(shaped.model->bodies[1].visuals.size(), 1u);
  EXPECT_THAT(shaped.messages, HasSubstr("joint: it has shapes)"));
}

TEST(UrdfMassless, WhyAChainIsNoJointIsSaid) {
  const auto why = [](const std::string& second) {
    return read(heavy("base") + link("a", "") + heavy("arm") +
                joint("one", "continuous", "base", "a", axis("1 0 0")) + second)
        .messages;
  };
  EXPECT_THAT(
      why(joint("two", "continuous", "a", "arm", axis("0 1 0") + "<dynamics damping=\"0.1\"/>")),
      HasSubstr("the damping of `one` and `two` differs"));
  EXPECT_THAT(
      why(joint("two", "continuous", "a", "arm", axis("0 1 0") + "<origin xyz=\"0 0 1\"/>")),
      HasSubstr("the origins of `one` and `two` differ"));
  EXPECT_THAT(why(joint("two", "continuous", "a", "arm", axis("0.5 1 0"))),
              HasSubstr("the axes of `one` and `two` are not orthogonal"));
}

TEST(UrdfMassless, MotionWithoutInertiaIsRefused) {
  const auto refusal = [](const std::string& second) {
    const Read refused = read(heavy("base") + link("a", "") + heavy("arm") +
                              joint("one", "continuous", "base", "a", axis("1 0 0")) + second);
    EXPECT_FALSE(refused.model);
    return refused.messages;
  };
  EXPECT_THAT(refusal(joint("two", "continuous", "a", "arm", axis("-1 0 0"))),
              HasSubstr("error: the link `a` has no <inertial> and moves on the joint `one`; give "
                        "it a mass, or fix the joint: the joint `two` moves it about the same "
                        "axis"));
  EXPECT_THAT(refusal(joint("two", "floating", "a", "arm")),
              HasSubstr("give it a mass, or fix the joint: nothing that hangs on it has mass"));
}

TEST(UrdfMassless, JointsThatMoveNoMassAreReadAsFixed) {
  const Read leaf = read(heavy("base") + link("propeller", "") +
                         joint("spin", "continuous", "base", "propeller", axis("0 0 1")));
  ASSERT_TRUE(leaf.model) << leaf.messages;
  EXPECT_EQ(leaf.model->bodies.size(), 1u);
  EXPECT_EQ(leaf.model->find_link("propeller"), 1);
  EXPECT_THAT(leaf.messages, HasSubstr("warning: the joint `spin` is read as fixed: nothing that "
                                       "hangs on it has mass"));
}

TEST(FoldWarnings, KeepsOneOfEachKindAndErrors) {
  Diagnostics diagnostics;
  diagnostics.warning({"a.urdf", 3, 0}, "the link `a` weighs 1 kg");
  diagnostics.warning({"a.urdf", 4, 0}, "<b> elements are ignored");
  diagnostics.warning({"a.urdf", 5, 0}, "the link `b` weighs 2.5 kg");
  diagnostics.error({"a.urdf", 6, 0}, "the link `c` weighs -1 kg");
  diagnostics.warning({"b.urdf", 7, 0}, "the link `d` weighs 2 kg");
  for (int line = 10; line < 17; ++line) {
    diagnostics.warning({"a.urdf", line, 0},
                        "<c" + std::to_string(line) + "> elements are ignored");
  }
  EXPECT_EQ(
      fold_warnings(diagnostics).to_string(),
      "a.urdf:3: warning: the link `a` weighs 1 kg (and 1 more of this kind, in line 5)\n"
      "a.urdf:4: warning: <b> elements are ignored\n"
      "a.urdf:6: error: the link `c` weighs -1 kg\n"
      "b.urdf:7: warning: the link `d` weighs 2 kg\n"
      "a.urdf:10: warning: <c10> elements are ignored (and 6 more of this kind, in lines 11, 12, "
      "13, 14, 15, ...)\n");
}

TEST(FoldWarnings, ListsEachLineOnce) {
  Diagnostics diagnostics;
  for (const int line : {1, 1, 1, 2}) {
    const std::string name = std::to_string(diagnostics.all().size());
    diagnostics.warning({"a.urdf", line, 0}, "the link `" + name + "` is light");
  }
  EXPECT_EQ(fold_warnings(diagnostics).to_string(),
            "a.urdf:1: warning: the link `0` is light (and 3 more of this kind, in lines 1, 2)\n");
}

TEST(FoldWarnings, FoldMoreThanAreShown) {
  Diagnostics diagnostics(1000);
  for (int line = 1; line <= 999; ++line) {
    diagnostics.warning({"a.urdf", line, 0}, "the link `" + std::to_string(line) + "` is light");
  }
  EXPECT_EQ(
      fold_warnings(diagnostics).to_string(),
      "a.urdf:1: warning: the link `1` is light (and 998 more of this kind, in lines 2, 3, 4, "
      "5, 6, ...)\n");
}

TEST(FoldWarnings, KeepsCountOfErrorsThatAreNotShown) {
  Diagnostics diagnostics;
  for (int line = 1; line <= 150; ++line) diagnostics.error({"a.urdf", line, 0}, "wrong");
  const Diagnostics folded = fold_warnings(diagnostics);
  EXPECT_EQ(folded.error_count(), 150);
  EXPECT_THAT(folded.to_string(), HasSubstr("50 more errors are not shown"));
}

}  // namespace
}  // namespace skybody
