// Shapes in files: capsules, planes and height fields of scenarios; capsules and meshes of URDFs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/files/height_field_reader.h"
#include "core/io/urdf/mesh_box.h"
#include "core/io/urdf/urdf_reader.h"
#include "core/io/yaml/scenario_reader.h"
#include "tests/unit/io/fake_catalog.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

using ::testing::HasSubstr;

const char* const kInertial =
    "<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
    "izz=\"1\"/></inertial>";

/// A model whose base has one collision shape.
std::string model_with(const std::string& shape) {
  return "<robot name=\"r\">\n<link name=\"base\">" + std::string(kInertial) +
         "<collision><geometry>" + shape + "</geometry></collision></link></robot>\n";
}

/// A tetrahedron whose box is from (0, 0, 0) to (1, 2, 3).
const char* const kStl = R"(solid t
facet normal 0 0 -1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 2 0
endloop
endfacet
facet normal 0 -1 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 3
endloop
endfacet
endsolid t
)";

class ShapeFiles : public ::testing::Test {
 protected:
  std::optional<RobotModel> read_model(const std::string& shape) {
    diagnostics_ = Diagnostics();
    return read_urdf(folder_.write("m/r.urdf", model_with(shape)), {}, diagnostics_);
  }

  /// The first obstacle of a scenario; nothing if it is refused.
  std::optional<Shape> read_obstacle(const std::string& keys) {
    diagnostics_ = Diagnostics();
    folder_.write("r.urdf", model_with("<sphere radius=\"1\"/>"));
    const std::string text = "robots: [{name: r, model: r.urdf}]\nobstacles:\n  - {name: o, " +
                             keys + "}\ntask: {plugin: hover, parameters: {robot: r}}\n";
    const auto scenario = read_scenario(folder_.write("s.yaml", text), {}, catalog_, diagnostics_);
    if (!scenario || scenario->obstacles.empty()) return std::nullopt;
    hash_ = scenario->hash;
    return scenario->obstacles[0].shape;
  }

  std::string messages() const { return diagnostics_.to_string(); }

  TempFolder folder_;
  FakeCatalog catalog_;
  Diagnostics diagnostics_;
  std::uint64_t hash_ = 0;
};

TEST_F(ShapeFiles, ObstaclesAreCapsulesAndPlanes) {
  const auto capsule = read_obstacle("capsule: [0.1, 2]");
  ASSERT_TRUE(capsule.has_value()) << messages();
  EXPECT_EQ(capsule->type, ShapeType::kCapsule);
  EXPECT_EQ(capsule->radius, 0.1);
  EXPECT_EQ(capsule->length, 2.0);
  const auto plane = read_obstacle("plane: true, rpy: [0, 0.3, 0]");
  ASSERT_TRUE(plane.has_value()) << messages();
  EXPECT_EQ(plane->type, ShapeType::kPlane);
  EXPECT_FALSE(read_obstacle("plane: false").has_value());
  EXPECT_THAT(messages(), HasSubstr("s.yaml:3:22: error: `plane` is false; allowed: true"));
}

TEST_F(ShapeFiles, HeightsStandInTheScenarioOrInAFile) {
  const auto written =
      read_obstacle("height_field: {size: [2, 4], columns: 3, heights: [0, 1, 2, 3, 4, 5]}");
  ASSERT_TRUE(written.has_value()) << messages();
  EXPECT_EQ(written->type, ShapeType::kHeightField);
  EXPECT_EQ(written->size.y, 4.0);
  EXPECT_EQ(written->heights->columns(), 3);
  EXPECT_EQ(written->heights->rows(), 2);
  EXPECT_EQ(written->heights->highest(), 5.0);
  folder_.write("hills.csv", "# by hand\n0, 1,2\r\n\n3,4, 5e0\n");
  const auto read = read_obstacle("height_field: {size: [2, 4], file: hills.csv}");
  ASSERT_TRUE(read.has_value()) << messages();
  EXPECT_EQ(read->heights->heights(), written->heights->heights());
  const std::uint64_t before = hash_;
  folder_.write("hills.csv", "0,1,2\n3,4,6\n");
  ASSERT_TRUE(read_obstacle("height_field: {size: [2, 4], file: hills.csv}").has_value());
  EXPECT_NE(hash_, before) << "heights belong to the scenario's hash";
}

TEST_F(ShapeFiles, HeightsThatAreNoGridAreRefusedWithTheirLine) {
  const auto refused = [&](const std::string& text) {
    folder_.write("hills.csv", text);
    EXPECT_FALSE(read_obstacle("height_field: {size: [1, 1], file: hills.csv}").has_value());
    return messages();
  };
  EXPECT_THAT(refused("0,1\n2,3,4\n"),
              HasSubstr("hills.csv:2: error: the row has 3 heights, that of line 1 has 2"));
  EXPECT_THAT(refused("0,1\n2,secret\n"),
              HasSubstr("hills.csv:2: error: height 2 of the row is no number"));
  EXPECT_THAT(messages(), ::testing::Not(HasSubstr("secret"))) << "files are not quoted";
  EXPECT_THAT(refused("0,1\n2,.inf\n"), HasSubstr("height 2 of the row is"));
  EXPECT_THAT(refused("0,1\n2,.nan\n"), HasSubstr("height 2 of the row is"));
  EXPECT_THAT(refused("0,1\n2,1e9\n"), HasSubstr("allowed: from -1000000 to 1000000 m"));
  EXPECT_THAT(refused("0,1\n2,\n"), HasSubstr("height 2 of the row is no number"));
  EXPECT_THAT(refused("0,1\n"), HasSubstr("the file has 1 rows of 2 heights"));
  EXPECT_THAT(refused(""), HasSubstr("the file has 0 rows of 0 heights"));
  std::string many;
  for (int i = 0; i < 1100; ++i) {
    for (int k = 0; k < 1000; ++k) many += k == 0 ? "0" : ",0";
    many += '\n';
  }
  EXPECT_THAT(refused(many), HasSubstr("hills.csv:1049: error: the file has more than 1048576"));
}

TEST_F(ShapeFiles, HeightFieldsHaveOneSourceOfHeights) {
  const auto refused = [&](const std::string& value) {
    EXPECT_FALSE(read_obstacle("height_field: " + value).has_value());
    return messages();
  };
  EXPECT_THAT(refused("{size: [1, 1]}"), HasSubstr("`height_field` has no heights"));
  EXPECT_THAT(refused("{size: [1, 1], file: a.csv, heights: [1]}"),
              HasSubstr("has `file` and `heights`"));
  EXPECT_THAT(refused("{size: [1, 1], file: missing.csv}"),
              HasSubstr("missing.csv` does not exist"));
  EXPECT_THAT(refused("{size: [1, 1], file: /etc/passwd}"), HasSubstr("whose name ends in .csv"));
  EXPECT_THAT(refused("{size: [1, 1], heights: [1, 2, 3, 4]}"), HasSubstr("`columns` is missing"));
  EXPECT_THAT(refused("{size: [1, 1], columns: 3, heights: [1, 2, 3, 4]}"),
              HasSubstr("has 4 numbers, but `columns` is 3"));
  EXPECT_THAT(refused("{columns: 2, heights: [1, 2, 3, 4]}"), HasSubstr("has no `size`"));
  EXPECT_THAT(refused("hills.csv"), HasSubstr("allowed: a map of size, file, heights, columns"));
  std::filesystem::create_directory(folder_.path("folder.csv"));
  EXPECT_THAT(refused("{size: [1, 1], file: folder.csv}"), HasSubstr("is a folder"));
}

TEST_F(ShapeFiles, UrdfsHaveCapsules) {
  const auto model = read_model("<capsule radius=\"0.1\" length=\"0.5\"/>");
  ASSERT_TRUE(model.has_value()) << messages();
  EXPECT_EQ(messages(), "");
  const Shape& shape = model->bodies[0].collisions.at(0);
  EXPECT_EQ(shape.type, ShapeType::kCapsule);
  EXPECT_EQ(shape.radius, 0.1);
  EXPECT_EQ(shape.length, 0.5);
  EXPECT_FALSE(read_model("<capsule radius=\"0\" length=\"0.5\"/>").has_value());
  EXPECT_THAT(messages(), HasSubstr("`radius` of <capsule> in the link `base` is 0"));
}

TEST_F(ShapeFiles, MeshesAreTheBoxAboutThem) {
  folder_.write("m/t.stl", kStl);
  const auto model = read_model("<mesh filename=\"t.stl\" scale=\"0.1 -0.1 1\"/>");
  ASSERT_TRUE(model.has_value()) << messages();
  EXPECT_THAT(messages(),
              HasSubstr("r.urdf:2:136: warning: the mesh `t.stl` of the link `base` counts "
                        "in contact as the box about it, 0.1 x 0.2 x 3 m"));
  const Shape& shape = model->bodies[0].collisions.at(0);
  EXPECT_EQ(shape.type, ShapeType::kMesh);
  EXPECT_NEAR(shape.box_size.x, 0.1, 1e-12);
  EXPECT_NEAR(shape.box_center.y, -0.1, 1e-12);
  EXPECT_NEAR(shape.box_center.z, 1.5, 1e-12);
  const Shape box = contact_shape(shape);
  EXPECT_EQ(box.type, ShapeType::kBox);
  EXPECT_EQ(box.size.z, 3.0);
}

TEST_F(ShapeFiles, MeshesOfAllFormatsThatAreRead) {
  folder_.write("m/t.obj",
                "mtllib other.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\nf 1 2 4\n");
  folder_.write("m/t.ply",
                "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
                "end_header\n0 0 0\n1 0 0\n0 2 0\n0 0 3\n3 0 1 2\n3 0 1 3\n");
  folder_.write("m/t.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01" name="centimeter"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 100 0 0 0 200 0 0 0 300</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 1 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
)");
  folder_.write("m/T.STL", kStl);
  for (const char* name : {"t.obj", "t.ply", "t.dae", "T.STL"}) {
    const auto model = read_model("<mesh filename=\"" + std::string(name) + "\"/>");
    ASSERT_TRUE(model.has_value()) << messages();
    const Vec3<double> size = model->bodies[0].collisions.at(0).box_size;
    EXPECT_NEAR(size.x, 1.0, 1e-6) << name;
    EXPECT_NEAR(size.y, 2.0, 1e-6) << name;
    EXPECT_NEAR(size.z, 3.0, 1e-6) << name;
  }
}

TEST_F(ShapeFiles, MeshesWithoutABoxAreRefusedWithTheReason) {
  const auto refused = [&](const std::string& name, const std::string& text,
                           const std::string& scale = "1 1 1") {
    folder_.write("m/" + name, text);
    EXPECT_FALSE(
        read_model("<mesh filename=\"" + name + "\" scale=\"" + scale + "\"/>").has_value());
    return messages();
  };
  EXPECT_THAT(refused("bad.dae", "<COLLADA>"),
              HasSubstr("r.urdf:2:136: error: the mesh `bad.dae`"));
  EXPECT_THAT(messages(), HasSubstr("cannot be read"));
  EXPECT_THAT(messages(), HasSubstr("mend it, or write a box, cylinder, sphere or capsule"));
  EXPECT_THAT(refused("empty.obj", "# nothing\n"), HasSubstr("the mesh `empty.obj`"));
  EXPECT_THAT(refused("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n"),
              HasSubstr("is flat: it is 1 x 2 x 0 m"));
  EXPECT_THAT(refused("thin.stl", kStl, "1 0 1"), HasSubstr("is flat: it is 1 x 0 x 3 m"));
  EXPECT_THAT(refused("far.stl", kStl, "1e6 1 1e6"), HasSubstr("farther off than 1000000 m"));
  EXPECT_THAT(refused("t.fbx", kStl),
              HasSubstr("is of a format that is not read (.stl, .dae, .obj, .ply are)"));
  EXPECT_THAT(refused("large.stl", std::string(kLargestMesh + 1, ' ')),
              HasSubstr("is larger than 32 MiB"));
  // A file of one format with the extension of another is not passed to other importers.
  EXPECT_THAT(refused("is_ply.dae", "ply\nformat ascii 1.0\nend_header\n"),
              HasSubstr("cannot be read"));
}

TEST_F(ShapeFiles, AMeshOfAVisualIsNotRead) {
  folder_.write("m/bad.stl", "");
  const std::string file = folder_.write(
      "m/v.urdf", "<robot name=\"r\"><link name=\"base\">" + std::string(kInertial) +
                      "<visual><geometry><mesh filename=\"bad.stl\"/></geometry></visual></link>"
                      "</robot>");
  Diagnostics diagnostics;
  EXPECT_TRUE(read_urdf(file, {}, diagnostics).has_value());
  EXPECT_EQ(diagnostics.to_string(), "");
}

}  // namespace
}  // namespace skybody
