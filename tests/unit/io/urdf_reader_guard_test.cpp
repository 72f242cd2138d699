// Untrusted URDFs: names that readers decode differently, duplicate parts, numbers of no real
// robot, meshes outside the model, and more links than any vehicle has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/urdf/urdf_reader.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

const std::string kMass =
    "<mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>";
const std::string kInertial = "<inertial>" + kMass + "</inertial>";

std::string link(const std::string& name, const std::string& content = kInertial) {
  return "<link name=\"" + name + "\">" + content + "</link>\n";
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& content = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + content + "</joint>\n";
}

/// Errors and warnings; the first line of `body` is line 2.
std::string messages(const std::string& body, bool good = false) {
  Diagnostics diagnostics;
  const auto model =
      parse_urdf("<robot name=\"r\">\n" + body + "</robot>\n", "r.urdf", {}, diagnostics);
  EXPECT_EQ(model.has_value(), good) << diagnostics.to_string();
  return diagnostics.to_string();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  text.replace(text.find(from), from.size(), to);
  return text;
}

TEST(Urdf, RefusesABareAmpersandInAName) {
  EXPECT_EQ(messages(link("base") + link("a&b") + joint("j", "fixed", "base", "a&b")),
            "r.urdf:3:14: error: a bare `&`, which XML forbids; write `&amp;`\n");
  for (const char* bad : {"a&", "a&amp", "a&;", "a&#;", "a&#x;", "a&#xyz;", "&&amp;"}) {
    EXPECT_THAT(messages(link(bad)),
                AllOf(StartsWith("r.urdf:2:1"), HasSubstr(": error: a bare `&`")))
        << bad;
  }
}

TEST(Urdf, MessagesHaveTheColumnOfTheElement) {
  const std::string heavy = replaced(kInertial, "value=\"1\"", "value=\"-1\"");
  const std::string body = "<!-- <a> <b/> -->  " + link("base", "<visual/>" + heavy) +
                           "\t<link\n  name=\"a\"/> <link name=\"a\"/>\n";
  EXPECT_EQ(messages(body),
            "r.urdf:2:38: error: <visual> of the link `base` has no <geometry>\n"
            "r.urdf:2:57: error: the mass of the link `base` is -1; allowed: 0, or from 1e-20 to "
            "1e+12 kg\n"
            "r.urdf:4:14: error: a second link called `a`; the first is in line 3; names must "
            "differ\n");
}

TEST(Urdf, RefusesTextOutsideOfTheElementAtTheTop) {
  const std::string robot = "<robot name=\"r\">" + link("base") + "</robot>";
  const auto told = [](const std::string& text) {
    Diagnostics diagnostics;
    parse_urdf(text, "r.urdf", {}, diagnostics);
    return diagnostics.to_string();
  };
  const std::string nowhere = " the element at the top, where XML allows none; remove it\n";
  EXPECT_EQ(told(robot + "\n x y \n"), "r.urdf:3:2: error: the text `x y` stands after" + nowhere);
  EXPECT_EQ(told(robot + "<!-- c -->>"), "r.urdf:2:19: error: the text `>` stands after" + nowhere);
  EXPECT_EQ(told("<?xml version=\"1.0\"?>1<!-- c -->" + robot),
            "r.urdf:1:22: error: the text `1` stands before" + nowhere);
  EXPECT_EQ(told(robot + "<![CDATA[x]]>"),
            "r.urdf:2:9: error: the text `<![CDATA[x]]>` stands after" + nowhere);
  EXPECT_EQ(told(robot + "\n<link/>"),
            "r.urdf:3:1: error: a second element at the top; XML allows one: remove it\n");
  EXPECT_EQ(told("\xEF\xBB\xBF<!DOCTYPE robot>\n" + robot + " \r\n\t<!-- end -->\n"), "");
}

TEST(Urdf, TakesReferencesAndAmpersandsInComments) {
  const std::string body = "<!-- a & b -->\n" + link("a&amp;b&lt;&#65;&#x42;&apos;");
  Diagnostics diagnostics;
  const auto model =
      parse_urdf("<?xml version=\"1.0\"?><!-- & --><robot name=\"r\">\n" + body + "</robot>",
                 "r.urdf", {}, diagnostics);
  ASSERT_TRUE(model.has_value()) << diagnostics.to_string();
  EXPECT_EQ(model->links[0].name, "a&b<AB'");
}

TEST(Urdf, RefusesLineBreaksAndControlCharactersInNames) {
  const std::string expected = "holds a line break, another control character or bytes that are no";
  for (const char* bad : {"a\nb", "a\tb", "a&#10;b", "a&#27;b", "a\xff"}) {
    EXPECT_THAT(
        messages(link("base") + link(bad) + joint("j", "fixed", "base", bad)),
        AllOf(HasSubstr("r.urdf:3:1: error: the name of this <link>, `a"), HasSubstr(expected)))
        << bad;
  }
  EXPECT_THAT(messages(link("base") + link("a") + joint("j&#10;", "fixed", "base", "a")),
              HasSubstr("the name of this <joint>, `j\\x0a`, " + expected));
  EXPECT_THAT(messages(link("a\x01")),
              HasSubstr("the control character `\\x01`, which XML forbids"));
  EXPECT_THAT(messages(link(std::string(201, 'a'))),
              HasSubstr("the name of this <link> has 201 bytes; allowed: at most 200"));
}

TEST(Urdf, RefusesWhatMayStandOnce) {
  EXPECT_EQ(messages(link("base", kInertial + "\n" + kInertial)),
            "r.urdf:3:1: error: a second <inertial> in <link> of the link `base`; the first is in "
            "line 2; remove one\n");
  EXPECT_THAT(messages(link("base", "<inertial>" + kMass + "<mass value=\"2\"/></inertial>")),
              HasSubstr("a second <mass> in <inertial> of the link `base`"));
  const std::string sphere = "<sphere radius=\"1\"/>";
  const std::string visual = "<visual><geometry>" + sphere + "</geometry></visual>";
  EXPECT_THAT(messages(link("base", kInertial + replaced(visual, sphere, sphere + sphere))),
              HasSubstr("a second shape, <sphere>, in <geometry> of the link `base`; write another "
                        "<visual> for it"));
  EXPECT_THAT(messages(link("base", kInertial + replaced(visual, "<geometry>",
                                                         "<geometry>" + sphere +
                                                             "</geometry>"
                                                             "<geometry>"))),
              HasSubstr("a second <geometry> in <visual>"));
  EXPECT_THAT(messages(link("base", "<inertial><origin/><origin/>" + kMass + "</inertial>")),
              HasSubstr("a second <origin> in <inertial>"));
  const std::string limit = "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>";
  const std::string axis = "<axis xyz=\"0 0 1\"/>";
  for (const std::string& part :
       {limit, axis, std::string("<origin/>"), std::string("<parent link=\"base\"/>"),
        std::string("<child link=\"a\"/>"), std::string("<dynamics damping=\"1\"/>")}) {
    const std::string twice = part == limit ? limit + limit : limit + part + part;
    EXPECT_THAT(
        messages(link("base") + link("a") + joint("j", "revolute", "base", "a", twice)),
        AllOf(StartsWith("r.urdf:4:"),
              HasSubstr(": error: a second <" + part.substr(1, part.find_first_of(" /") - 1) +
                        "> in <joint> of the joint `j`; the first is in line 4")))
        << part;
  }
}

TEST(Urdf, RefusesMassesAndSizesThatNoRobotHas) {
  const auto with = [](const std::string& from, const std::string& to) {
    return messages(link("base", replaced(kInertial, from, to)));
  };
  for (const char* mass : {"5e-324", "1e300", "-1", "1e13"}) {
    EXPECT_THAT(with("value=\"1\"", "value=\"" + std::string(mass) + "\""),
                AllOf(HasSubstr("r.urdf:2:29: error: the mass of the link `base` is "),
                      HasSubstr("; allowed: 0, or from 1e-20 to 1e+12 kg")))
        << mass;
  }
  for (const char* moment : {"1e-300", "1e300", "-1e300"}) {
    EXPECT_THAT(with("ixx=\"1\"", "ixx=\"" + std::string(moment) + "\""),
                HasSubstr("allowed: 0, or from 1e-40 to 1e+24 kg m^2"));
  }
  EXPECT_THAT(with("ixy=\"0\"", "ixy=\"1e300\""),
              HasSubstr("allowed: from -1e+24 to 1e+24 kg m^2"));
  EXPECT_THAT(with("<mass", "<origin xyz=\"0 1e200 0\"/><mass"),
              HasSubstr("`xyz` of <origin> in the link `base` is 1e+200; allowed: from -1000000 to "
                        "1000000 m"));
  EXPECT_THAT(with("<mass", "<origin rpy=\"0 1e200 0\"/><mass"),
              HasSubstr("allowed: from -1000 to 1000 rad"));
  const std::string collision = "<collision><geometry><sphere radius=\"";
  for (const char* radius : {"5e-324", "0", "-1", "1e200"}) {
    EXPECT_THAT(
        messages(link("base", kInertial + collision + radius + "\"/></geometry></collision>")),
        HasSubstr("; allowed: from 1e-09 to 1000000 m"))
        << radius;
  }
}

TEST(Urdf, RefusesJointNumbersThatNoRobotHas) {
  const auto with = [](const std::string& content) {
    return messages(link("base") + link("a") + joint("j", "revolute", "base", "a", content));
  };
  const std::string limit = "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>";
  EXPECT_THAT(
      with(replaced(limit, "\"-1\"", "\"-1e200\"")),
      HasSubstr("the lower limit of the joint `j` is -1e+200; allowed: from -1e+18 to 1e+18"));
  EXPECT_THAT(with(limit + "<dynamics damping=\"1e300\"/>"),
              HasSubstr("the damping of the joint `j` is 1e+300; allowed: from 0 to 1000000"));
  EXPECT_THAT(with(limit + "<axis xyz=\"1e-7 0 0\"/>"), HasSubstr("must be at least 1e-06 long"));
  EXPECT_THAT(with(limit + "<axis xyz=\"0 0 1e300\"/>"),
              HasSubstr("allowed: from -1000000 to 1000000"));
}

TEST(Urdf, RefusesMoreThanTenThousandLinks) {
  std::string body;
  for (int i = 0; i < 100'000; ++i) body += "<link name=\"l" + std::to_string(i) + "\"/>\n";
  EXPECT_THAT(messages(body), HasSubstr("r.urdf:10002:1: error: more than 10000 links"));
}

TEST(Urdf, ReadsTenThousandLinksInAChain) {
  for (const char* type : {"fixed", "continuous"}) {
    std::string body = link("l0");
    for (int i = 1; i < 10'000; ++i) {
      const std::string name = std::to_string(i);
      body += link('l' + name) + joint('j' + name, type, 'l' + std::to_string(i - 1), 'l' + name);
    }
    EXPECT_EQ(messages(body, true), "") << type;
  }
}

TEST(Urdf, RefusesTenThousandMasslessLinksInAChain) {
  std::string body = link("l0");
  for (int i = 1; i < 10'000; ++i) {
    const std::string name = std::to_string(i);
    body += link('l' + name, i == 9'999 ? kInertial : "") +
            joint('j' + name, "continuous", 'l' + std::to_string(i - 1), 'l' + name);
  }
  EXPECT_THAT(messages(body), HasSubstr("the joint `j2` moves it about the same axis"));
}

TEST(Urdf, RefusesDeepXmlAndElementsOfManyAttributes) {
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  EXPECT_THAT(messages(deep), HasSubstr("not well-formed XML: element depth exceeded"));
  std::string wide = "<link name=\"base\"";
  for (int i = 0; i < 100'000; ++i) wide += " a" + std::to_string(i) + "=\"1\"";
  EXPECT_THAT(messages(wide + "/>"),
              HasSubstr("r.urdf:2:804: error: an element with more than 100 attributes"));
}

TEST(Urdf, TakesEqualSignsInTextAndValuesForNoAttributes) {
  const std::string many(200, '=');
  EXPECT_EQ(messages(link("base") + "<gazebo a='" + many + "'>" + many + "</gazebo>", true),
            "r.urdf:3:1: warning: <gazebo> elements are ignored\n");
}

TEST(Urdf, RefusesReferencesThatXmlDoesNotKnow) {
  EXPECT_THAT(messages("<link name=\"&foo;\"/>"),
              HasSubstr("the reference `&foo;`, which XML does not know; write `&amp;`"));
}

TEST(Urdf, TakesAnyWhiteSpaceBetweenNumbers) {
  const std::string mass = replaced(kInertial, "value=\"1\"", "value=\" 1.0\t\"");
  const std::string origin = replaced(mass, "<mass", "<origin xyz=\"0\n 0\t1 \"/><mass");
  Diagnostics diagnostics;
  const auto model = parse_urdf("<robot name=\"r\">" + link("1 2", origin) + "</robot>", "r.urdf",
                                {}, diagnostics);
  ASSERT_TRUE(model.has_value()) << diagnostics.to_string();
  EXPECT_EQ(model->bodies[0].mass.mass, 1.0);
  EXPECT_EQ(model->bodies[0].mass.com.z, 1.0);
}

TEST(Urdf, RefusesTheReferenceToNul) {
  EXPECT_THAT(messages(link("a&#0;b")), HasSubstr("r.urdf:2:14: error: a bare `&`"));
}

TEST(Urdf, EveryMaterialNeedsAColour) {
  const std::string visual =
      "<visual><geometry><sphere radius=\"1\"/></geometry><material name=\"red\"/></visual>";
  EXPECT_THAT(
      messages(link("base", kInertial + visual)),
      HasSubstr("the material `red` of the link `base` has no <color> and is not declared"));
  Diagnostics diagnostics;
  const auto model = parse_urdf("<robot name=\"r\">" + link("base", kInertial + visual) +
                                    "<material name=\"red\"><color rgba=\"1 0.2 0 1\"/></material>"
                                    "</robot>",
                                "r.urdf", {}, diagnostics);
  ASSERT_TRUE(model.has_value()) << diagnostics.to_string();
  EXPECT_FLOAT_EQ(static_cast<float>(model->bodies[0].visuals[0].rgba[1]), 0.2f);
}

/// Messages about a sphere with a texture; `file` is its path then.
std::string texture_messages(const TempFolder& folder, const std::string& name, std::string& file) {
  Diagnostics diagnostics;
  const auto model = parse_urdf(
      "<robot name=\"r\">" +
          link("base", kInertial + "<visual><geometry><sphere radius=\"1\"/></geometry>"
                                   "<material name=\"skin\"/></visual>") +
          "<material name=\"skin\"><texture filename=\"" + name + "\"/></material></robot>",
      folder.path("pack/urdf/r.urdf"), {}, diagnostics);
  file = model ? model->bodies[0].visuals[0].texture_file : "no model";
  return diagnostics.to_string();
}

TEST(Urdf, TexturesAreFoundAsMeshesAre) {
  const TempFolder folder;
  folder.write("pack/urdf/r.urdf", "");
  const std::string path = folder.write("pack/textures/skin.png", "");
  folder.write("skin.png", "");
  std::string file;
  EXPECT_EQ(texture_messages(folder, "../textures/skin.png", file), "");
  EXPECT_EQ(file, std::filesystem::canonical(path).string());
  EXPECT_EQ(texture_messages(folder, "package://pack/textures/skin.png", file), "");
  EXPECT_EQ(file, std::filesystem::canonical(path).string());
  EXPECT_THAT(texture_messages(folder, "none.png", file),
              HasSubstr("warning: the texture `none.png` of the link `base` does not exist; its "
                        "colour remains"));
  EXPECT_EQ(file, "");
  EXPECT_THAT(texture_messages(folder, "../../skin.png", file), HasSubstr("lies outside"));
  EXPECT_EQ(file, "");
}

std::string mesh_of(const std::string& file) {
  return "<visual><geometry><mesh filename=\"" + file + "\"/></geometry></visual>";
}

/// Messages about a model in pack/urdf with a visual mesh of this name.
std::string mesh_messages(const TempFolder& folder, const std::string& mesh) {
  const std::string file =
      folder.write("ws/pack/urdf/r.urdf",
                   "<robot name=\"r\">" + link("base", kInertial + mesh_of(mesh)) + "</robot>");
  Diagnostics diagnostics;
  EXPECT_TRUE(read_urdf(file, {}, diagnostics).has_value()) << diagnostics.to_string();
  return diagnostics.to_string();
}

TEST(UrdfMeshes, InTheModelsFolderOrItsPackageAreTaken) {
  TempFolder folder;
  folder.write("ws/pack/meshes/a.stl", "solid");
  folder.write("ws/pack/urdf/b.STL", "solid");
  folder.write("ws/other/package.xml", "<package/>");
  folder.write("ws/other/meshes/c.dae", "<COLLADA/>");
  for (const std::string& name :
       {std::string("../meshes/a.stl"), std::string("b.STL"),
        std::string("package://pack/meshes/a.stl"), std::string("package://any/meshes/a.stl"),
        std::string("package://other/meshes/c.dae"),
        "file://" + folder.path("ws/pack/meshes/a.stl")}) {
    EXPECT_EQ(mesh_messages(folder, name), "") << name;
  }
}

TEST(UrdfMeshes, AnywhereInTheirPackageAreTaken) {
  TempFolder folder;
  folder.write("ws/package.xml", "<package/>");
  folder.write("ws/meshes/a.stl", "solid");
  EXPECT_EQ(mesh_messages(folder, "../../meshes/a.stl"), "");
}

TEST(UrdfMeshes, ElsewhereAreLeftOutWithAWarning) {
  TempFolder folder;
  folder.write("secret.stl", "solid");
  folder.write("ws/other/meshes/c.dae", "no package.xml beside it");
  std::filesystem::create_directories(folder.path("ws/pack/urdf"));
  std::filesystem::create_symlink(folder.path("secret.stl"), folder.path("ws/pack/urdf/s.stl"));
  for (const std::string& name :
       {std::string("../../../secret.stl"), folder.path("secret.stl"), std::string("s.stl"),
        "file://" + folder.path("secret.stl"), std::string("package://pack/../../secret.stl"),
        std::string("../../../not_there.stl")}) {
    EXPECT_THAT(mesh_messages(folder, name),
                HasSubstr("lies outside the model's folder and the one above it; it is left out"))
        << name;
  }
  EXPECT_THAT(mesh_messages(folder, "package://other/meshes/c.dae"), HasSubstr("does not exist"));
}

TEST(UrdfMeshes, OtherFilesAreNoMeshes) {
  TempFolder folder;
  for (const char* name :
       {"/etc/passwd", "../../../etc/passwd", "package://etc/passwd", "r.urdf"}) {
    EXPECT_THAT(mesh_messages(folder, name),
                AllOf(HasSubstr("has no extension of a mesh"), Not(HasSubstr("root:"))))
        << name;
  }
}

}  // namespace
}  // namespace skybody
