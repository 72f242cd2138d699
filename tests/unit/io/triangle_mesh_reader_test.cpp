// Triangles of mesh files in every format and form of faces, by their areas, and of height fields.
#include "core/io/urdf/triangle_mesh_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/math/vec3.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Vec3<double> corner(const TriangleMesh& mesh, std::size_t triangle, std::size_t k) {
  const float* const v = mesh.corners.data() + 9 * triangle + 3 * k;
  return {v[0], v[1], v[2]};
}

/// Half the sum of cross products: of a flat mesh with one sense of rotation its area, along the
/// normal.
Vec3<double> area(const TriangleMesh& mesh) {
  Vec3<double> sum{0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < static_cast<std::size_t>(mesh.count()); ++i) {
    const Vec3<double> a = corner(mesh, i, 0);
    sum += cross(corner(mesh, i, 1) - a, corner(mesh, i, 2) - a) * 0.5;
  }
  return sum;
}

class TriangleMeshes : public ::testing::Test {
 protected:
  /// Number of triangles and z of the area, or the problem.
  std::string read(const std::string& name, const std::string& bytes) {
    TriangleMesh mesh;
    const std::string problem =
        read_triangle_mesh(folder_.write(name, bytes), *find_mesh_format(name), mesh);
    if (!problem.empty()) return problem;
    char text[64];
    std::snprintf(text, sizeof text, "%d triangles, area %.6g", mesh.count(), area(mesh).z);
    return text;
  }

  TempFolder folder_;
};

/// A rectangle of 2 x 3 m about z, as one COLLADA primitive.
std::string collada(const std::string& primitive) {
  return R"(<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1"/></asset><library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="12">0 0 0 2 0 0 2 3 0 0 3 0</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>)" +
         primitive + R"(</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node><scale>1 2 1</scale>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>)";
}

const char* const kInput = R"(<input semantic="VERTEX" source="#v" offset="0"/>)";

TEST_F(TriangleMeshes, StlInText) {
  EXPECT_EQ(read("a.stl",
                 "solid a\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 2 0 0 vertex 2 3 0 "
                 "endloop endfacet\nendsolid a\n"),
            "1 triangles, area 3");
}

TEST_F(TriangleMeshes, ObjWithPolygonsOfLaterVerticesAndNegativeNumbers) {
  const std::string vertices = "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\n";
  EXPECT_EQ(read("a.obj", "f 1 2 3 4\n" + vertices), "2 triangles, area 6");
  EXPECT_EQ(read("b.obj", vertices + "f -4/1/1 -3/1/1 -2/1/1\n"), "1 triangles, area 3");
  EXPECT_EQ(read("c.obj", vertices + "l 1 2\n"), "has no faces");
}

TEST_F(TriangleMeshes, ObjHasThePointsOfItsTexture) {
  const std::string vertices = "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\n";
  const auto texture_of = [&](const std::string& lines) {
    TriangleMesh mesh;
    EXPECT_EQ(read_triangle_mesh(folder_.write("a.obj", vertices + lines),
                                 *find_mesh_format("a.obj"), mesh),
              "");
    return mesh.texture;
  };
  const std::string points = "vt 0 0\nvt 1 0\nvt 1 0.5 7\n";
  // A fan; points from the end; a corner without one.
  EXPECT_THAT(texture_of(points + "f 1/1 2/2/4 3/3 4\n"),
              ElementsAre(0, 0, 1, 0, 1, 0.5f, 0, 0, 1, 0.5f, 0, 0));
  EXPECT_THAT(texture_of(points + "f 1/-3 2/-2 3/-1\n"), ElementsAre(0, 0, 1, 0, 1, 0.5f));
  EXPECT_THAT(texture_of(points + "f 1/9 2/-9 3/0\n"), ElementsAre(0, 0, 0, 0, 0, 0));
  EXPECT_TRUE(texture_of("f 1/1 2/2 3/3\n").empty());
}

TEST_F(TriangleMeshes, PlyWithFacesBeforeVertices) {
  EXPECT_EQ(read("a.ply",
                 "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
                 "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                 "end_header\n4 0 1 2 3\n0 0 0\n2 0 0\n2 3 0\n0 3 0\n"),
            "2 triangles, area 6");
}

TEST_F(TriangleMeshes, ColladaWithEveryKindOfFaces) {
  const auto part = [](const std::string& kind, const std::string& counts, const std::string& p) {
    return collada("<" + kind + " count=\"" + (kind == "triangles" ? "2" : "1") + "\">" + kInput +
                   counts + "<p>" + p + "</p></" + kind + ">");
  };
  // The node's scale doubles the width.
  EXPECT_EQ(read("a.dae", part("triangles", "", "0 1 2 0 2 3")), "2 triangles, area 12");
  EXPECT_EQ(read("b.dae", part("polylist", "<vcount>4</vcount>", "0 1 2 3")),
            "2 triangles, area 12");
  EXPECT_EQ(read("c.dae", part("polygons", "", "0 1 2 3")), "2 triangles, area 12");
  EXPECT_EQ(read("d.dae", part("trifans", "", "0 1 2 3")), "2 triangles, area 12");
  EXPECT_EQ(read("e.dae", part("tristrips", "", "0 1 3 2")), "2 triangles, area 12");
  EXPECT_EQ(read("f.dae", part("lines", "", "0 1")), "has no faces");
}

TEST_F(TriangleMeshes, DamagedFilesHaveAReason) {
  EXPECT_THAT(read("a.obj", "v 0 0 0\nf 1 2 3\n"), HasSubstr("cannot be drawn: line 2"));
  EXPECT_THAT(read("a.stl", "solid a\nfacet\n"), HasSubstr("cannot be drawn: line"));
}

TEST_F(TriangleMeshes, TooManyTrianglesAreRefused) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int k = 0; k <= kMostMeshTriangles; ++k) text += "f 1 2 3\n";
  EXPECT_EQ(read("a.obj", text),
            "cannot be drawn: has more than 60000 triangles, which is the most that is drawn");
}

TEST(TriangulateHeightField, HasTheDiagonalsOfContact) {
  const HeightField field(3, 2, {0.0, 1.0, 2.0, 0.5, 1.5, 2.5});
  TriangleMesh mesh;
  EXPECT_EQ(triangulate(field, 4.0, 3.0, mesh), "");
  EXPECT_EQ(mesh.count(), 4);
  EXPECT_NEAR(area(mesh).z, 12.0, 1e-5);
  // The first cell: from its corner of least x and y to the opposite one.
  EXPECT_EQ(corner(mesh, 0, 0).x, -2.0);
  EXPECT_EQ(corner(mesh, 0, 0).y, -1.5);
  EXPECT_EQ(corner(mesh, 0, 2).x, 0.0);
  EXPECT_EQ(corner(mesh, 0, 2).z, 1.5);
}

}  // namespace
}  // namespace skybody
